"""The results of a study: convergence of each method on each scene, costs, and the extra runs."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import NoneType
from typing import Any

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import SEED, ConvergenceStudy
from plumbob.engines.study.cost import Cost, Key, SceneCosts
from plumbob.engines.study.provenance import Provenance
from plumbob.engines.study.request import Answer, Request
from plumbob.engines.study.stability import SmallestLimit, StabilitySearch
from plumbob.models.registry import case_of, system_of
from plumbob.models.scene import Observable, Quantity, Scene

Observables = tuple[Observable, ...]
Quantities = tuple[Quantity, ...]


@dataclass(frozen=True)
class Analysed:
    """The numbers of one analysis of a study, for its template."""

    template: str
    place: str  # "finding", "gallery", or "hard"
    system: str  # name of a system, or "engines"
    scene: str  # name of a hard scene, or ""
    # None if the analysis is left out, since runs of the study are not as expected
    numbers: Any
    claims: tuple[tuple[str, bool], ...] = ()
    """Checks: (why the check would fail, whether it holds). If there are no numbers: the pairs of
    scene and method whose verdicts are unexpected."""


@dataclass(frozen=True)
class TaskResult:
    """The result of one task of a study: a convergence study, costs, an analysis, or the answer to
    a request."""

    answer: Any = None  # None if the task was given up, or its request has no answer
    request: Request[Any] | None = None  # None for a convergence study, costs or an analysis
    scene: str = ""  # name of the scene with which it is loaded, if it belongs to one
    label: str = ""  # description of the task
    lost: str = ""  # why the task was given up

    @property
    def subject(self) -> Any:
        """The identity of the result within a study: its request, its scene and method, or its
        analysis. No two results of a study have the same."""
        of = self.answer
        if isinstance(of, Analysed):
            return of.template, of.place, of.system, of.scene
        return self.request or (getattr(of, "scene", self.scene), getattr(of, "method", ""))


@dataclass(frozen=True)
class Study:
    """Everything that was measured: errors of each method on each scene, costs, extra runs."""

    profile: str  # "quick" or "full"
    scenes: tuple[Scene, ...]
    methods: tuple[Method, ...]
    convergence: tuple[ConvergenceStudy, ...] = ()
    costs: Mapping[Key, Cost] = field(default_factory=dict)
    reference_step: float = math.nan  # [ns] time of a bare step of an empty model in this study
    observed: Mapping[str, Observables] = field(default_factory=dict)
    """The observables of each scene. They are stored so that pages need not load the systems."""
    interest: Mapping[str, Quantities] = field(default_factory=dict)
    """The quantities of interest of each scene, stored for the same reason."""
    extras: Mapping[Request[Any], Any] = field(default_factory=dict)  # answers by request
    analyses: tuple[Analysed, ...] = ()
    provenance: Provenance = field(default_factory=Provenance)
    seed: int = SEED  # seed of the one step of each pair that is drawn at random

    def observables(self, scene: str) -> Observables:
        """The observables of a scene, the leading one first."""
        if scene in self.observed:
            return self.observed[scene]
        return system_of(next(s for s in self.scenes if s.name == scene)).observables

    def quantities(self, scene: str) -> Quantities:
        """The quantities of interest of a scene: observables with scales, the most telling one
        first."""
        if scene in self.interest:
            return self.interest[scene]
        case = case_of(next(s for s in self.scenes if s.name == scene))
        return case.system.quantities(case)

    def described(self) -> Study:
        """The study with the observables and quantities of interest of all its scenes filled in."""
        names = [scene.name for scene in self.scenes]
        return replace(
            self,
            observed={name: self.observables(name) for name in names},
            interest={name: self.quantities(name) for name in names},
        )

    def answer(self, request: Request[Answer]) -> Answer | None:
        """The answer to a declared request. None if the request's engine is missing, its method is
        not meant for the scene or does not support it, or its run diverged. Raises LookupError if
        no analysis has declared the request."""
        try:
            answer: Answer | None = self.extras[request]
        except KeyError:
            raise LookupError(
                f"no finding declared {request}: add it to `requests` of the section that shows it"
            ) from None
        return answer

    def step_limit(self, scene: str, method: str) -> SmallestLimit | None:
        """The smallest stored limit of the step of a scene with a method: a measured one if there
        is any, else a predicted one, else None."""
        for by_runs in (True, False):
            search = self.extras.get(StabilitySearch(scene, method, by_runs))
            if search and search.limits:
                limit = min(search.limits, key=lambda limit: limit.largest)
                return SmallestLimit(limit.kind, limit.largest, limit.measured, limit.why)
        return None


def coherent(study: Study) -> Study:
    """Returns the study if its parts belong together; raises ValueError if they do not, as may
    happen with a damaged file."""
    scenes = [scene.name for scene in study.scenes]
    methods = [method.name for method in study.methods]
    posed = [(scene.duration, scene.steps, dict(scene.parameters)) for scene in study.scenes]
    json.dumps(posed, allow_nan=False)  # raises ValueError
    names = {scene: {o.name for o in study.observed.get(scene, ())} for scene in scenes}
    about = {scene: {q.observable for q in study.interest.get(scene, ())} for scene in scenes}
    if not all(about[scene] and about[scene] <= names[scene] for scene in scenes):
        raise ValueError("its scenes are not about their observables")
    if not all(isinstance(a.numbers, (Mapping, NoneType)) for a in study.analyses):
        raise ValueError("an analysis has no numbers by name")
    for series in study.convergence:
        runs = (*series.measurements, *filter(None, [series.drawn]))
        observed = names.get(series.scene, set())
        if series.method not in methods or not all(set(run.errors) <= observed for run in runs):
            raise ValueError(
                f"{series.method} on {series.scene} is not of its scenes and methods"
            )
    return study


def assembled_study(head: Study, results: Iterable[TaskResult]) -> Study:
    """The study `head` with these results. Its costs are scaled to one reference step."""
    parts = tuple(results)
    answers = [part.answer for part in parts if part.request is None]
    costs = {}
    for of in answers:
        if isinstance(of, SceneCosts):
            scale = head.reference_step / of.reference_step
            for method, cost in of.by_method.items():
                costs[of.scene, method] = cost.scaled(scale) if math.isfinite(scale) else cost
    return replace(
        head,
        convergence=tuple(of for of in answers if isinstance(of, ConvergenceStudy)),
        costs=costs,
        extras={part.request: part.answer for part in parts if part.request is not None},
        analyses=tuple(of for of in answers if isinstance(of, Analysed)),
    )
