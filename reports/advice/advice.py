"""The cheapest method and step for a scene, or for the hardest of a family of scenes.

The answer is made from a study of the scenes, whose runs every method is judged by, and from runs
at steps between and beyond its own. The tables of a page are the answers from its study alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from plumbob.analytic.parameters import positive
from plumbob.engines.method import Method
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Quantities, Study
from plumbob.models.scene import Quantity, Scene
from plumbob.reports.advice.recommend import (
    DEFAULT_METHOD,
    DEFAULT_STEP,
    EXACT,
    Choice,
    Recommendation,
    trusted,
)
from plumbob.reports.advice.step_search import Evidence, searched
from plumbob.reports.judge.study_verdicts import Judgements, judge_study

SECONDS = 45.0  # [s] of computing, roughly, that the search for steps may take
PER_SCENE = 5.0  # [s] more for each further scene of a family
Run = Callable[[Scene, Method, float], Measurement]


@dataclass(frozen=True)
class Question:
    """A question: scenes by one name or pattern, and the error that is wanted."""

    name: str
    scenes: tuple[Scene, ...]
    methods: tuple[Method, ...]
    error: float  # relative, or in the unit of the observable
    absolute: bool = False
    observable: str | None = None  # the one whose absolute error is meant; None: the first

    def quantities(self, study: Study, scene: str) -> Quantities:
        """The quantities of a scene whose errors count: those that it is about, or one observable,
        at its end if the scene is about that."""
        about = study.quantities(scene)
        if not self.absolute:
            return about
        wanted = self.observable or about[0].observable
        of_interest = (q for q in about if q.observable == wanted)
        return (replace(next(of_interest, Quantity(wanted, 1.0)), scale=1.0),)


@dataclass(frozen=True)
class Answer:
    """The recommendation, the evidence for it, and whether the search was cut short."""

    recommendation: Recommendation
    evidence: Evidence
    cut_short: bool


def advise(
    asked: Question, study: Study, run: Run | None = None, judged: Judgements | None = None
) -> Answer:
    """The cheapest method and step that reach an error on every scene asked about, from a `study`
    of these and from more runs; without `run`, for these, what was measured counts alone. Raises
    ParameterError for an error that is not positive."""
    evidence = _evidence(asked, study)
    evidence.run, evidence.seconds = run, SECONDS + PER_SCENE * (len(asked.scenes) - 1)
    every = _trusted(asked, study, evidence, judged)
    full = [m for m in every if not m.surrogate]
    within = searched(evidence, full, asked.error)
    choice = within[0] if within else None
    by_engine = {c.method.partition("/")[0]: c for c in reversed(within)}
    surrogate: Choice | None = None
    if choice:
        surrogates = [m for m in every if m.surrogate]
        cheaper = searched(evidence, surrogates, asked.error, choice.ns_per_second)
        surrogate = next((c for c in cheaper if c.ns_per_second < choice.ns_per_second), None)
    observable = evidence.quantities[asked.scenes[0].name][0].observable
    units = {o.name: o.unit for o in study.observables(asked.scenes[0].name)}
    everything = [] if choice else _choices(evidence, full)
    recommendation = Recommendation(
        asked.name,
        observable,
        units[observable],
        asked.error,
        asked.error * evidence.scale,
        choice,
        within[1] if len(within) > 1 else None,
        tuple(c for c in within if c in by_engine.values()),
        min(everything, key=lambda c: (c.error, c.ns_per_second), default=None),
        tuple(_defaults(asked, evidence, choice)),
        surrogate,
    )
    return Answer(recommendation, evidence, evidence.seconds <= 0.0)


def from_study(
    study: Study, scene: Scene, error: float, judged: Judgements | None = None
) -> Recommendation:
    """The answer from one study of a scene, for a relative error; raises ParameterError."""
    asked = Question(scene.name, (scene,), study.methods, error)
    return advise(asked, study, judged=judged).recommendation


def every_choice(asked: Question, study: Study, judged: Judgements) -> list[Choice]:
    """Every run of a full model, on all scenes asked about, that may be named."""
    evidence = _evidence(asked, study)
    every = _trusted(asked, study, evidence, judged)
    return _choices(evidence, [m for m in every if not m.surrogate])


def _choices(evidence: Evidence, methods: Sequence[Method]) -> list[Choice]:
    return [c for m in methods for c in evidence.choices(m, evidence.allowed(m))]


def _defaults(asked: Question, evidence: Evidence, choice: Choice | None) -> list[Choice]:
    """MuJoCo's default settings and the chosen method at its default step, where that was run."""
    named = (DEFAULT_METHOD, choice.method if choice else DEFAULT_METHOD)
    usual = [m for name in dict.fromkeys(named) for m in asked.methods if m.name == name]
    fixed = [m for m in usual if m.control == "step" and _timed(m, evidence)]
    return [c for m in fixed for c in evidence.choices(m) if c.step == DEFAULT_STEP]


def _evidence(asked: Question, study: Study) -> Evidence:
    """Every run, cost and limit that a study has of the scenes; raises ParameterError."""
    positive("absolute" if asked.absolute else "error", asked.error)
    keys = [(scene.name, method.name) for scene in asked.scenes for method in asked.methods]
    runs: dict[tuple[str, str], dict[float, Measurement]] = {key: {} for key in keys}
    for c in study.convergence:
        if (c.scene, c.method) in runs:
            done = [m for m in c.measurements if m.status in ("done", "diverged")]
            runs[c.scene, c.method] = {m.step: m for m in done}
    return Evidence(
        asked.scenes,
        {scene.name: asked.quantities(study, scene.name) for scene in asked.scenes},
        {key: cost.ns_per_step for key, cost in study.costs.items()},
        runs,
        limits={key: limit for key in keys if (limit := study.step_limit(*key))},
    )


def _timed(method: Method, evidence: Evidence) -> bool:
    """Whether a method simulates all scenes, and was timed on them."""
    exact = method.scheme.integrator == EXACT
    return not exact and all((s.name, method.name) in evidence.costs for s in evidence.scenes)


def _trusted(
    asked: Question, study: Study, evidence: Evidence, judged: Judgements | None
) -> list[Method]:
    """The methods that may be named: nothing is known against them on any scene."""
    verdicts = judge_study(study) if judged is None else judged
    return [
        m
        for m in asked.methods
        if _timed(m, evidence)
        and evidence.allowed(m) > 0.0
        and all(
            trusted(
                verdicts.get((scene.name, m.name)),
                list(evidence.runs[scene.name, m.name].values()),
                study.quantities(scene.name),
            )
            for scene in asked.scenes
        )
    ]
