"""The cheapest method and step for a scene, or for the hardest of a family of scenes.

The answer is made from everything that is stored of the installed versions, and from runs that are
made for it: convergence studies of methods that have none, on which they are judged, and runs at
steps between and beyond them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from plumbob.analytic.parameters import ParameterError, positive
from plumbob.engines.method import Method, meant
from plumbob.engines.study.cost import Cost, Key
from plumbob.engines.study.measurement import Measurement, measure
from plumbob.engines.study.merged_studies import merged
from plumbob.engines.study.results import Quantities, Study
from plumbob.models.registry import case_of
from plumbob.models.scene import Quantity, Scene
from plumbob.reports.advice.recommend import (
    DEFAULT_STEP,
    EXACT,
    Choice,
    Recommendation,
    Wanted,
    recommended,
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
    asked: Question,
    known: Mapping[str, Known],
    run_studies: RunStudies | None,
    seconds: float = SECONDS,
    progress: Callable[[str], None] = lambda what: None,
) -> Answer:
    """The cheapest method and step that reach an error on every scene asked about; without
    `run_studies`, for convergence studies, nothing is run and only what is known counts;
    `progress` is given what is being run. Raises ParameterError for an error that is not positive,
    and for an observable that there is not."""
    positive("error" if asked.observable is None else "absolute", asked.error)
    gathering = _Gathering(asked, dict(known), run_studies, [])
    study = gathering.with_methods(asked.scenes[:1], asked.methods)
    quantities = {scene.name: gathering.quantities(scene) for scene in asked.scenes}

    def run(scene: Scene, method: Method, step: float) -> Measurement:
        progress(f"{scene.name} {method.name} at {step:.3g}")
        return measure(case_of(scene), method, step, theory=False)[0]

    evidence = Evidence(
        asked.scenes,
        quantities,
        gathering.costs(),
        gathering.runs(),
        None if run_studies is None else run,
        seconds + PER_SCENE * (len(asked.scenes) - 1),
    )
    return Answer(
        _answer(asked, study, evidence, partial(gathering.trusts, evidence)),
        {name: of_scene.study for name, of_scene in gathering.known.items()},
        tuple(gathering.made),
        evidence.taken,
        evidence.seconds <= 0.0,
    )


def _answer(
    asked: Question, study: Study, evidence: Evidence, good: Callable[[Method], bool]
) -> Recommendation:
    """The recommendation from steps that are searched for; surrogates only where they may be
    cheaper than the full model that is chosen."""
    scale = max(q[0].scale for q in evidence.quantities.values())
    methods = [
        m
        for m in asked.methods
        if m.scheme.integrator != EXACT
        and all(meant(m, scene) for scene in asked.scenes)
        and math.isfinite(evidence.price(m))
    ]
    full = [m for m in methods if not m.surrogate]
    within = searched(evidence, full, asked.error, good, scale)
    best = None if within else _best(evidence, full, good, scale)
    if within:
        others, cost = [m for m in methods if m.surrogate], within[0].ns_per_second
        within += searched(evidence, others, asked.error, good, scale, cost)
    first = asked.scenes[0].name
    observable = evidence.quantities[first][0].observable
    unit = next(o.unit for o in study.observables(first) if o.name == observable)
    wanted = Wanted(asked.name, observable, unit, asked.error, scale)
    return recommended(wanted, within, best, partial(_at_default, evidence, methods, scale))


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
            study,
            scenes=(scene,),
            convergence=tuple(c for c in study.convergence if c.scene == scene.name),
            costs={key: cost for key, cost in study.costs.items() if key[0] == scene.name},
        )
        old = self.known.get(scene.name)
        both = merged([old.study, part] if old else [part], scene)
        assert both is not None
        self.known[scene.name] = Known(both, old.searched if old else {})

    def quantities(self, scene: Scene) -> Quantities:
        """The quantities of a scene whose errors count; raises ParameterError."""
        if scene.name in self.known:
            study = self.known[scene.name].study
        else:
            case = case_of(scene)
            study = replace(
                self.known[self.asked.scenes[0].name].study,
                scenes=(scene,),
                observed={scene.name: case.system.observables},
                interest={scene.name: case.system.quantities(case)},
            )
        return counted(study, scene.name, self.asked.observable)

    def trusts(self, evidence: Evidence, method: Method) -> bool:
        """Whether nothing is known against a method on any scene; convergence studies that are
        missing are run for it, and are evidence too."""
        for scene in self.asked.scenes:
            at_once = [scene] if scene == self.asked.scenes[0] else self.asked.scenes
            self.with_methods(at_once, [method])
            if scene.name not in self.known or not self._good(scene.name, method.name):
                return False
        for key, runs in self.runs().items():
            there = evidence.runs.setdefault(key, {})
            there.update({h: m for h, m in runs.items() if h not in there})
        return True

    def _good(self, scene: str, method: str) -> bool:
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


def _best(
    evidence: Evidence, methods: Sequence[Method], good: Callable[[Method], bool], scale: float
) -> Choice | None:
    """The run with the smallest error on the hardest scene, of methods that converge."""
    choices = [
        _at(evidence, m, h, scale)
        for m in methods
        if evidence.common(m, math.inf) and good(m)
        for h in evidence.common(m, math.inf)
    ]
    done = [c for c in choices if math.isfinite(c.error)]
    return min(done, key=lambda c: (c.error, c.ns_per_second), default=None)


def _at_default(
    evidence: Evidence, methods: Sequence[Method], scale: float, name: str
) -> Choice | None:
    """A method at MuJoCo's default step, where that was run on every scene."""
    method = next((m for m in methods if m.name == name and m.control == "step"), None)
    if method is None or DEFAULT_STEP not in evidence.common(method, math.inf):
        return None
    choice = _at(evidence, method, DEFAULT_STEP, scale)
    return choice if math.isfinite(choice.error) else None


def _at(evidence: Evidence, method: Method, step: float, scale: float) -> Choice:
    return as_choice(evidence, method, step, scale, evidence.worst(method, step))
