"""The cheapest method and step for a scene, or for the hardest of a family of scenes.

A study of the scenes judges every method. The answer uses the runs of the study, and more runs at
steps between and below the study's. The tables of a page use the study alone.
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

SECONDS = 45.0  # [s] computing time, roughly, of the search for steps
PER_SCENE = 5.0  # [s] computing time that each further scene of a family adds
Run = Callable[[Scene, Method, float], Measurement]


@dataclass(frozen=True)
class Question:
    """A question for the cheapest method: the scenes, the methods, and the wanted error."""

    name: str
    scenes: tuple[Scene, ...]
    methods: tuple[Method, ...]
    error: float  # relative, or in the unit of the observable
    absolute: bool = False
    # Name of the observable whose absolute error is meant; None: the first quantity of interest.
    observable: str | None = None

    def quantities(self, study: Study, scene: str) -> Quantities:
        """Returns the quantities of a scene whose errors count. For a relative error they are the
        scene's quantities of interest. For an absolute error it is one observable with the scale 1;
        if the scene's quantity of interest is that observable at the end, the error at the end
        counts."""
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
    """Returns the cheapest method and step that reach an error on every scene asked about. `study`
    is a study of the scenes; `run` makes more runs. Without `run`, the measured runs alone count.
    `judged` are the study's verdicts, if they are known already. Raises ParameterError for an error
    that is not positive."""
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
    """Returns the recommendation for one scene and a relative error, from the runs of a study
    alone; raises ParameterError for an error that is not positive."""
    asked = Question(scene.name, (scene,), study.methods, error)
    return advise(asked, study, judged=judged).recommendation


def every_choice(asked: Question, study: Study, judged: Judgements) -> list[Choice]:
    """Returns every run of a full model, made on all scenes asked about, that may be
    recommended."""
    evidence = _evidence(asked, study)
    every = _trusted(asked, study, evidence, judged)
    return _choices(evidence, [m for m in every if not m.surrogate])


def _choices(evidence: Evidence, methods: Sequence[Method]) -> list[Choice]:
    """Returns the runs of these methods at steps that the limits of stability allow."""
    return [c for m in methods for c in evidence.choices(m, evidence.allowed(m))]


def _defaults(asked: Question, evidence: Evidence, choice: Choice | None) -> list[Choice]:
    """Returns the runs with MuJoCo's default settings, and with the chosen method at MuJoCo's
    default step, if these runs were made."""
    named = (DEFAULT_METHOD, choice.method if choice else DEFAULT_METHOD)
    usual = [m for name in dict.fromkeys(named) for m in asked.methods if m.name == name]
    fixed = [m for m in usual if m.control == "step" and _timed(m, evidence)]
    return [c for m in fixed for c in evidence.choices(m) if c.step == DEFAULT_STEP]


def _evidence(asked: Question, study: Study) -> Evidence:
    """Returns the runs, costs and limits that a study has of the scenes; raises ParameterError for
    an error that is not positive."""
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
    """Whether a method simulates all scenes, rather than evaluate a closed form, and was timed on
    them."""
    exact = method.scheme.integrator == EXACT
    return not exact and all((s.name, method.name) in evidence.costs for s in evidence.scenes)


def _trusted(
    asked: Question, study: Study, evidence: Evidence, judged: Judgements | None
) -> list[Method]:
    """Returns the methods that may be recommended: no scene shows a reason against them."""
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
