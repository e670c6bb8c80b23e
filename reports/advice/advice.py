"""The cheapest method and step for a scene, or for the hardest of a family of scenes.

The answer is made from everything that is stored of the installed versions, and from runs that are
made for it: convergence studies of methods that have none, on which they are judged, and runs at
steps between and beyond them. The tables of a page are the answers from its study alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from plumbob.analytic.parameters import ParameterError, positive
from plumbob.engines.method import Method, meant
from plumbob.engines.study.cost import Key
from plumbob.engines.study.measurement import Measurement, measure
from plumbob.engines.study.merged_studies import merged
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
from plumbob.reports.advice.step_search import Evidence, searched
from plumbob.reports.judge.study_verdicts import Judgements, judge_study

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
    absolute: bool = False
    observable: str | None = None  # the one whose absolute error is meant; None: the first

    def quantities(self, known: Mapping[str, Known]) -> dict[str, Quantities]:
        """The quantities of each scene whose errors count; raises ParameterError."""
        return {scene.name: self._of(scene, known) for scene in self.scenes}

    def _of(self, scene: Scene, known: Mapping[str, Known]) -> Quantities:
        """The quantities whose errors count: those that the scene is about, or one observable, at
        its end if the scene is about that. Raises ParameterError for one that there is not."""
        if scene.name in known:
            study = known[scene.name].study
            observables, about = study.observables(scene.name), study.quantities(scene.name)
        else:
            case = case_of(scene)
            observables, about = case.system.observables, case.system.quantities(case)
        if not self.absolute:
            return about
        wanted, names = self.observable or about[0].observable, [o.name for o in observables]
        if wanted not in names:
            raise ParameterError("observable", wanted, f"one of {', '.join(names)}")
        of_interest = (q for q in about if q.observable == wanted)
        return (replace(next(of_interest, Quantity(wanted, 1.0)), scale=1.0),)


@dataclass(frozen=True)
class Known:
    """Measurements of one scene: convergence studies, and runs at other steps, by method."""

    study: Study
    searched: Mapping[str, Sequence[Measurement]] = field(default_factory=dict)
    judged: Judgements | None = None  # None: they are judged when they are asked for


@dataclass(frozen=True)
class Answer:
    """The recommendation, what was run for it, and whether the search was cut short."""

    recommendation: Recommendation
    studies: Mapping[str, Study]  # everything that the answer is made from, a scene each
    made: tuple[Study, ...]  # convergence studies that were run now
    runs: Mapping[Key, Sequence[Measurement]]  # at other steps
    cut_short: bool


def advise(
    asked: Question,
    known: Mapping[str, Known],
    run_studies: RunStudies | None = None,
    seconds: float = SECONDS,
    progress: Callable[[str], None] = lambda what: None,
) -> Answer:
    """The cheapest method and step that reach an error on every scene asked about; without
    `run_studies`, for convergence studies, nothing is run and only what is known counts;
    `progress` is given what is being run. Raises ParameterError for an error that is not positive,
    and for an observable that there is not."""
    positive("absolute" if asked.absolute else "error", asked.error)

    def run(scene: Scene, method: Method, step: float) -> Measurement:
        progress(f"{scene.name} {method.name} at {step:.3g}")
        return measure(case_of(scene), method, step, theory=False)[0]

    gathering = _Gathering(asked, known, run_studies)
    first, evidence = asked.scenes[0], gathering.evidence
    gathering.complete([first], asked.methods)
    if first.name not in gathering.known:
        raise ParameterError("scene", first.name, "one that was measured, as nothing is to be run")
    if run_studies is not None:
        evidence.run, evidence.seconds = run, seconds + PER_SCENE * (len(asked.scenes) - 1)
    return Answer(
        _recommendation(gathering),
        {name: of_scene.study for name, of_scene in gathering.known.items()},
        tuple(gathering.made),
        evidence.taken,
        evidence.seconds <= 0.0,
    )


def from_study(
    study: Study, scene: Scene, error: float, judged: Judgements | None = None
) -> Recommendation:
    """The answer from one study of a scene, for a relative error; raises ParameterError."""
    known = {scene.name: Known(study.of_scene(scene.name), judged=judged)}
    return advise(Question(scene.name, (scene,), study.methods, error), known).recommendation


def every_choice(asked: Question, known: Mapping[str, Known]) -> list[Choice]:
    """Every run of a full model, on all scenes asked about, that may be named."""
    return _Gathering(asked, known).choices()


def _recommendation(gathering: _Gathering) -> Recommendation:
    """The recommendation from steps that are searched for; surrogates only where they may be
    cheaper than the full model that is chosen."""
    asked, evidence = gathering.asked, gathering.evidence
    full, surrogates = (gathering.methods(kind) for kind in (False, True))
    within = searched(evidence, full, asked.error, gathering.trusts)
    choice = within[0] if within else None
    by_engine = {c.method.partition("/")[0]: c for c in reversed(within)}
    cheaper: Sequence[Choice] = ()
    if choice:
        limit = choice.ns_per_second
        within_it = searched(evidence, surrogates, asked.error, gathering.trusts, limit)
        cheaper = [c for c in within_it if c.ns_per_second < limit]
    named = (DEFAULT_METHOD, choice.method if choice else DEFAULT_METHOD)
    usual = [m for name in dict.fromkeys(named) for m in full + surrogates if m.name == name]
    study = gathering.known[asked.scenes[0].name].study
    observable = evidence.quantities[asked.scenes[0].name][0].observable
    everything = () if choice else gathering.choices()
    return Recommendation(
        asked.name,
        observable,
        next(o.unit for o in study.observables(asked.scenes[0].name) if o.name == observable),
        asked.error,
        asked.error * evidence.scale,
        choice,
        within[1] if len(within) > 1 else None,
        tuple(c for c in within if c in by_engine.values()),
        min(everything, key=lambda c: (c.error, c.ns_per_second), default=None),
        tuple(default for m in usual if (default := evidence.at(m, DEFAULT_STEP))),
        cheaper[0] if cheaper else None,
    )


class _Gathering:
    """Gathers the measurements of each scene, and runs those that are missing."""

    def __init__(
        self,
        asked: Question,
        known: Mapping[str, Known],
        run_studies: RunStudies | None = None,
    ) -> None:
        self.asked, self.known, self.run_studies = asked, dict(known), run_studies
        self.made: list[Study] = []
        self.evidence = Evidence(asked.scenes, asked.quantities(known))
        for name in known:
            self._learn(name)

    def _learn(self, scene: str) -> None:
        """Every run, cost and limit that is known of a scene."""
        study, evidence = self.known[scene].study, self.evidence
        first = self.known.get(self.asked.scenes[0].name)
        unit = first.study.reference_step if first else math.nan  # the machine of the first scene
        runs = {c.method: c.measurements for c in study.convergence}
        for method in study.methods:
            key = scene, method.name
            kept = [m for m in runs.get(method.name, ()) if m.status in ("done", "diverged")]
            kept += self.known[scene].searched.get(method.name, ())
            evidence.runs.setdefault(key, {}).update({m.step: m for m in kept})
            if limit := study.step_limit(*key):
                evidence.limits[key] = limit
            if cost := study.costs.get(key):
                ns = cost.ratio * unit
                evidence.costs[key] = ns if math.isfinite(ns) else cost.ns_per_step

    def methods(self, surrogate: bool) -> list[Method]:
        """Methods that simulate all scenes and were timed: surrogates, or full models."""
        return [
            m
            for m in self.asked.methods
            if m.scheme.integrator != EXACT
            and bool(m.surrogate) is surrogate
            and all(meant(m, scene) for scene in self.asked.scenes)
            and math.isfinite(self.evidence.price(m))
        ]

    def choices(self) -> list[Choice]:
        """Every run of a full model, on all scenes asked about, that may be named."""
        every = ((m, self.evidence.choices(m)) for m in self.methods(False))
        return [c for m, of in every if of and self.trusts(m) for c in of]

    def complete(self, scenes: Sequence[Scene], methods: Sequence[Method]) -> None:
        """Run the convergence studies of these methods on these scenes that are missing."""
        if self.run_studies is None:
            return
        missing: dict[tuple[str, ...], list[Scene]] = {}
        for scene in scenes:
            old = self.known.get(scene.name)
            there = {c.method for c in old.study.convergence} if old else set()
            lacking = tuple(m.name for m in methods if meant(m, scene) and m.name not in there)
            if lacking:
                missing.setdefault(lacking, []).append(scene)
        for lacking, of in missing.items():
            some = [m for m in methods if m.name in lacking]
            self.made.append(self.run_studies(of, some))
            for scene in of:
                old, study = self.known.get(scene.name), self.made[-1].of_scene(scene.name)
                both = merged([old.study, study] if old else [study], scene)
                assert both is not None
                self.known[scene.name] = Known(both, old.searched if old else {})
                self._learn(scene.name)

    def trusts(self, method: Method) -> bool:
        """Whether nothing is known against a method on any scene; convergence studies that are
        missing are run for it, and are evidence too."""
        for scene in self.asked.scenes:
            at_once = [scene] if scene == self.asked.scenes[0] else self.asked.scenes
            self.complete(at_once, [method])
            if scene.name not in self.known or not self._good(scene.name, method.name):
                return False
        return True

    def _good(self, scene: str, method: str) -> bool:
        """Whether nothing is known against a method on a scene."""
        known = self.known[scene]
        part = known.study.of_methods([method])
        judged = judge_study(part) if known.judged is None else known.judged
        return bool(part.convergence) and all(
            trusted(judged.get((scene, method)), c.measurements, part.quantities(scene))
            for c in part.convergence
        )
