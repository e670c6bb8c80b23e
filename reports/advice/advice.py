"""The cheapest method and step for a scene, or for the hardest of a family of scenes.

The answer is made from everything that is stored of the installed versions, and from runs that are
made for it: convergence studies of methods that have none, on which they are judged, and runs at
steps between and beyond them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from plumbob.analytic.parameters import ParameterError, positive
from plumbob.analytic.theory import no_theory
from plumbob.engines.method import Method, meant
from plumbob.engines.study.cost import Cost, Key
from plumbob.engines.study.measurement import Measurement, measure
from plumbob.engines.study.merged import merged
from plumbob.engines.study.results import Quantities, Study
from plumbob.models.registry import case_of
from plumbob.models.scene import Quantity, Scene
from plumbob.reports.advice.recommend import (
    DEFAULT_METHOD,
    DEFAULT_STEP,
    EXACT,
    Choice,
    Recommendation,
    trusted,
)
from plumbob.reports.advice.step_search import Evidence, as_choice, searched
from plumbob.reports.advice.work_precision import of_method, points
from plumbob.reports.judge.study_verdicts import Judgements, judge_study

_UNTIMED = Cost(1.0, 1.0, 1.0, 1.0, 0.0, 0)  # where only the errors of a curve count
SECONDS = 45.0  # [s] of computing, roughly, that the search for steps may take
PER_SCENE = 5.0  # [s] more for each further scene of a family
RunStudies = Callable[[Sequence[Scene], Sequence[Method]], Study]


@dataclass(frozen=True)
class Question:
    """A question: scenes by one name or pattern, and the error that is wanted."""

    name: str
    scenes: tuple[Scene, ...]
    methods: tuple[Method, ...]
    error: float  # relative, or in the unit of the observable
    observable: str | None = None  # the one whose error is meant, in its unit; None: relative


@dataclass(frozen=True)
class Known:
    """Measurements of one scene: convergence studies, and runs at other steps, by method."""

    study: Study
    searched: Mapping[str, Sequence[Measurement]]


@dataclass(frozen=True)
class Answer:
    """The recommendation, what was run for it, and whether the search was cut short."""

    recommendation: Recommendation
    studies: Mapping[str, Study]  # everything that the answer is made from, a scene each
    made: tuple[Study, ...]  # convergence studies that were run now
    runs: Mapping[Key, Sequence[Measurement]]  # at other steps
    cut_short: bool


def counted(study: Study, scene: str, observable: str | None) -> Quantities:
    """The quantities whose errors count: those that the scene is about, or one observable, at its
    end if the scene is about that. Raises ParameterError for an observable that there is not."""
    about = study.quantities(scene)
    if observable is None:
        return about
    names = [o.name for o in study.observables(scene)]
    if observable not in names:
        raise ParameterError("observable", observable, f"one of {', '.join(names)}")
    of_interest = next((q for q in about if q.observable == observable), None)
    return (replace(of_interest or Quantity(observable, 1.0), scale=1.0),)


def advise(
    asked: Question, known: Mapping[str, Known], run_studies: RunStudies | None,
    seconds: float = SECONDS, progress: Callable[[str], None] = lambda what: None,
) -> Answer:  # fmt: skip
    """The cheapest method and step that reach an error on every scene asked about; without
    `run_studies`, for convergence studies, nothing is run and only what is known counts;
    `progress` is given what is being run. Raises ParameterError for an error that is not positive,
    and for an observable that there is not."""
    positive("error" if asked.observable is None else "absolute", asked.error)
    gathering = _Gathering(asked, dict(known), run_studies, [])
    first = asked.scenes[0]
    study = gathering.with_methods([first], asked.methods)
    quantities = {s.name: counted(study, s.name, asked.observable) for s in [first]}
    for scene in asked.scenes[1:]:
        if scene.name in gathering.known:
            of_scene = gathering.known[scene.name].study
            quantities[scene.name] = counted(of_scene, scene.name, asked.observable)
        else:
            case = case_of(scene)
            about = replace(
                study, scenes=(scene,), observed={scene.name: case.system.observables},
                interest={scene.name: case.system.quantities(case)},
            )  # fmt: skip
            quantities[scene.name] = counted(about, scene.name, asked.observable)

    def run(scene: Scene, method: Method, step: float) -> Measurement:
        progress(f"{scene.name} {method.name} at {step:.3g}")
        return _run(scene, method, step)

    evidence = Evidence(
        asked.scenes, quantities, gathering.costs(), gathering.runs(),
        None if run_studies is None else run, seconds + PER_SCENE * (len(asked.scenes) - 1),
    )  # fmt: skip
    methods = [
        m
        for m in asked.methods
        if m.scheme.integrator != EXACT
        and all(meant(m, scene) for scene in asked.scenes)
        and math.isfinite(evidence.price(m))
    ]
    scale = max(q[0].scale for q in quantities.values())

    def good(method: Method) -> bool:
        for scene in asked.scenes:
            gathering.with_methods([scene] if scene == first else asked.scenes, [method])
            if scene.name not in gathering.known or not gathering.good(scene.name, method.name):
                return False
        for key, runs in gathering.runs().items():
            evidence.runs.setdefault(key, {}).update(
                {h: m for h, m in runs.items() if h not in evidence.runs[key]}
            )
        return True

    full = searched(
        evidence, [m for m in methods if not m.surrogate], asked.error, good, scale
    )  # fmt: skip
    others = [m for m in methods if m.surrogate]
    cost = full[0].ns_per_second if full else 0.0
    beside = searched(evidence, others, asked.error, good, scale, cost) if full else []
    return Answer(
        _answer(asked, study, full, beside, evidence, methods, good, quantities, scale),
        {name: of_scene.study for name, of_scene in gathering.known.items()},
        tuple(gathering.made),
        evidence.taken,
        evidence.seconds <= 0.0,
    )


@dataclass
class _Gathering:
    """Gathers the measurements of each scene, and runs those that are missing."""

    asked: Question
    known: dict[str, Known]
    run_studies: RunStudies | None
    made: list[Study]

    def with_methods(self, scenes: Sequence[Scene], methods: Sequence[Method]) -> Study:
        """The first scene's study, with convergence studies of these methods on these scenes, run
        where there is none."""
        if self.run_studies is not None:
            missing = {
                s.name: tuple(
                    m.name for m in methods if meant(m, s) and not self._has(s.name, m.name)
                )
                for s in scenes
            }
            for some in dict.fromkeys(names for names in missing.values() if names):
                now = [s for s in scenes if missing[s.name] == some]
                study = self.run_studies(now, [m for m in methods if m.name in some])
                self.made.append(study)
                for scene in now:
                    self._add(scene, study)
        first = self.asked.scenes[0].name
        if first not in self.known:
            raise ParameterError("scene", first, "measured before: without runs there is no answer")
        return self.known[first].study

    def _has(self, scene: str, method: str) -> bool:
        known = self.known.get(scene)
        return known is not None and any(c.method == method for c in known.study.convergence)

    def _add(self, scene: Scene, study: Study) -> None:
        part = replace(
            study, scenes=(scene,),
            convergence=tuple(c for c in study.convergence if c.scene == scene.name),
            costs={key: cost for key, cost in study.costs.items() if key[0] == scene.name},
        )  # fmt: skip
        old = self.known.get(scene.name)
        both = merged([old.study, part] if old else [part], scene)
        assert both is not None
        self.known[scene.name] = Known(both, old.searched if old else {})

    def good(self, scene: str, method: str) -> bool:
        """Whether nothing is known against a method on a scene."""
        study = self.known[scene].study
        part = replace(study, convergence=tuple(c for c in study.convergence if c.method == method))
        judged: Judgements = judge_study(part)
        by_name = {m.name: m for m in study.methods}
        if (scene, method) not in judged or by_name[method].scheme.integrator == EXACT:
            return False
        timed = replace(part, costs=dict.fromkeys(judged, _UNTIMED))
        return trusted(judged, scene, of_method(points(timed, scene), by_name[method]), method)

    def costs(self) -> dict[Key, float]:
        """[ns] of a step of each pair, brought to the machine of the first scene's study."""
        unit = self.known[self.asked.scenes[0].name].study.reference_step
        return {
            key: cost.ratio * unit if math.isfinite(unit) else cost.ns_per_step
            for known in self.known.values()
            for key, cost in known.study.costs.items()
            if cost.believed
        }

    def runs(self) -> dict[Key, dict[float, Measurement]]:
        """Every run by pair and step."""
        every: dict[Key, dict[float, Measurement]] = {}
        for scene, known in self.known.items():
            for c in known.study.convergence:
                every.setdefault((scene, c.method), {}).update(
                    {m.step: m for m in c.measurements if m.status in ("done", "diverged")}
                )
            for method, runs in known.searched.items():
                every.setdefault((scene, method), {}).update({m.step: m for m in runs})
        return every


def _run(scene: Scene, method: Method, step: float) -> Measurement:
    """One run, without a prediction of its error, which takes longer than the run."""
    return measure(replace(case_of(scene), errors=no_theory(None)), method, step)[0]


def _answer(
    asked: Question,
    study: Study,
    full: Sequence[Choice],
    beside: Sequence[Choice],
    evidence: Evidence,
    methods: Sequence[Method],
    good: Callable[[Method], bool],
    quantities: Mapping[str, Quantities],
    scale: float,
) -> Recommendation:
    first = asked.scenes[0].name
    observable = quantities[first][0].observable
    unit = next(o.unit for o in study.observables(first) if o.name == observable)
    choice = full[0] if full else None
    surrogate = beside[0] if choice and beside else None
    if surrogate and choice and surrogate.ns_per_second >= choice.ns_per_second:
        surrogate = None
    by_engine: dict[str, Choice] = {}
    for c in full:
        by_engine.setdefault(c.method.partition("/")[0], c)
    best = None if choice else _best(evidence, methods, good, scale)
    named = dict.fromkeys((DEFAULT_METHOD, *([choice.method] if choice else [])))
    defaults = [
        _at(evidence, m, DEFAULT_STEP, scale)
        for name in named
        for m in methods
        if m.name == name
        and m.control == "step"
        and all(DEFAULT_STEP in evidence.of(s, m) for s in asked.scenes)
    ]
    return Recommendation(
        asked.name, observable, unit, asked.error, asked.error * scale, choice,
        full[1] if len(full) > 1 else None, tuple(by_engine.values()), best,
        tuple(c for c in defaults if math.isfinite(c.error)), surrogate,
    )  # fmt: skip


def _best(
    evidence: Evidence, methods: Sequence[Method], good: Callable[[Method], bool], scale: float
) -> Choice | None:
    """The run with the smallest error on the hardest scene, of full models that converge."""
    choices = [
        _at(evidence, m, h, scale)
        for m in methods
        if not m.surrogate and evidence.common(m, math.inf) and good(m)
        for h in evidence.common(m, math.inf)
    ]
    done = [c for c in choices if math.isfinite(c.error)]
    return min(done, key=lambda c: (c.error, c.ns_per_second), default=None)


def _at(evidence: Evidence, method: Method, step: float, scale: float) -> Choice:
    return as_choice(evidence, method, step, scale, evidence.worst(method, step))
