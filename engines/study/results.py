"""The results of a study: convergence of each method on each scene, costs, and the extra runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from plumbob.engines.abilities import Trimming
from plumbob.engines.method import Method
from plumbob.engines.study.convergence import SEED, ConvergenceStudy
from plumbob.engines.study.cost import Cost, Key
from plumbob.engines.study.extra_runs import (
    ExtraConvergence,
    ExtraRun,
    ParameterFit,
    Request,
    Result,
    TrimmingRun,
    looked_up,
)
from plumbob.engines.study.gradient import Gradients, GradientSearch
from plumbob.engines.study.identification import Identification
from plumbob.engines.study.long_runs import LongRunSearch, MeasuredLongRun
from plumbob.engines.study.model_reading import ModelRead, ModelReading
from plumbob.engines.study.provenance import Provenance
from plumbob.engines.study.stability import (
    KnownLimit,
    PredictedLimits,
    Stability,
    StabilitySearch,
    StepPrediction,
    known_limit,
)
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import case_of, system_of
from plumbob.models.scene import Observable, Quantity, Scene

Observables = tuple[Observable, ...]
Quantities = tuple[Quantity, ...]


@dataclass(frozen=True)
class Analysed:
    """The numbers of one analysis of a study, as its template takes them."""

    template: str
    place: str  # "finding", "gallery", or "hard"
    system: str  # or "engines"
    scene: str  # of a hard one, or ""
    numbers: Any  # None: left out, since runs of the study are not as expected
    claims: tuple[tuple[str, bool], ...] = ()
    """Checks: why each would not hold, and whether it does; without numbers, the pairs of scene and
    method whose verdicts are unexpected."""


class Answers(Mapping[Request, Result]):
    """Answers to requests, each made where it is first asked for: recordings are long, and most
    readers of a study want none."""

    def __init__(self, makers: Mapping[Request, Callable[[], Result]]) -> None:
        self._makers = makers
        self._made: dict[Request, Result] = {}

    def __getitem__(self, request: Request) -> Result:
        if request not in self._made:
            self._made[request] = self._makers[request]()
        return self._made[request]

    def __contains__(self, request: object) -> bool:
        return request in self._makers

    def __iter__(self) -> Iterator[Request]:
        return iter(self._makers)

    def __len__(self) -> int:
        return len(self._makers)

    def __reduce__(self) -> tuple[type[dict[Request, Result]], tuple[dict[Request, Result]]]:
        return dict, (dict(self),)


@dataclass(frozen=True)
class TaskResult:
    """The result of one task of a study: a convergence study with recordings of it, extra runs, a
    cost with the reference step's [ns] beside it, or an analysis; or why it was given up."""

    convergence: ConvergenceStudy | None = None
    extras: Mapping[Request, Result] = field(default_factory=dict)
    cost: Cost | None = None
    reference_step: float = math.nan
    analysis: Analysed | None = None
    pair: Key = ("", "")  # scene and method of a convergence study, a cost or limits of the step
    label: str = ""
    lost: str = ""
    seconds: float = 0.0

    def given_up(self, label: str, why: str) -> TaskResult:
        """This, as what stands for a result that is given up."""
        convergence = self.convergence
        if convergence is not None:
            runs = tuple(replace(m, reason=why) for m in convergence.measurements)
            convergence = replace(convergence, measurements=runs)
        return replace(self, convergence=convergence, label=label, lost=why)


@dataclass(frozen=True)
class Study:
    """Everything that was measured: errors of each method on each scene, costs, extra runs."""

    profile: str  # "quick" or "full"
    scenes: tuple[Scene, ...]
    methods: tuple[Method, ...]
    convergence: tuple[ConvergenceStudy, ...] = ()
    costs: Mapping[Key, Cost] = field(default_factory=dict)
    reference_step: float = math.nan  # [ns] of a bare step of an empty model, in this study
    seconds: Mapping[str, float] = field(default_factory=dict)
    """Wall time of the two halves, "errors" and "costs"."""
    observed: Mapping[str, Observables] = field(default_factory=dict)
    """The observables of each scene, so that a reader need not load every system."""
    interest: Mapping[str, Quantities] = field(default_factory=dict)
    """The quantities of interest of each scene, likewise."""
    extras: Mapping[Request, Result] = field(default_factory=dict)  # what findings declared
    analyses: tuple[Analysed, ...] = ()
    provenance: Provenance = field(default_factory=Provenance)
    seed: int = SEED  # that drew one more step for each pair

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
        """This with observables and quantities of interest of all its scenes."""
        names = [scene.name for scene in self.scenes]
        return replace(
            self,
            observed={name: self.observables(name) for name in names},
            interest={name: self.quantities(name) for name in names},
        )

    def of_scene(self, scene: str) -> Study:
        """The part of this that is about one scene, of extra runs with its limits alone."""
        return replace(
            self,
            scenes=tuple(s for s in self.scenes if s.name == scene),
            convergence=tuple(c for c in self.convergence if c.scene == scene),
            costs={key: cost for key, cost in self.costs.items() if key[0] == scene},
            observed={scene: self.observables(scene)},
            interest={scene: self.quantities(scene)},
            extras={
                of: limits
                for of, limits in self.extras.items()
                if isinstance(of, StabilitySearch | StepPrediction) and of.scene == scene
            },
        )

    def of_methods(self, names: Collection[str]) -> Study:
        """The part of this that these methods ran."""
        return replace(
            self,
            methods=tuple(m for m in self.methods if m.name in names),
            convergence=tuple(c for c in self.convergence if c.method in names),
            costs={key: cost for key, cost in self.costs.items() if key[1] in names},
        )

    def leading(self, scene: str) -> Observable:
        """The observable that orders and verdicts of a scene lead with."""
        return self.observables(scene)[0]

    def recording(self, request: ExtraRun) -> Trajectory | None:
        """The recording of a declared run; None where the engine is missing, the method is not
        meant for the scene or does not support it, or the run diverged. Raises UndeclaredRun."""
        found = looked_up(self.extras, request)
        assert found is None or isinstance(found, Trajectory)
        return found

    def extra_convergence(self, request: ExtraConvergence) -> ConvergenceStudy | None:
        """A declared convergence study; None as for `recording`. Raises UndeclaredRun."""
        found = looked_up(self.extras, request)
        assert found is None or isinstance(found, ConvergenceStudy)
        return found

    def trimming_of(self, request: TrimmingRun) -> Trimming | None:
        """A declared timing of a trimmed model; None as for `recording`, and where the engine
        leaves nothing out. Raises UndeclaredRun."""
        found = looked_up(self.extras, request)
        assert found is None or isinstance(found, Trimming)
        return found

    def stability_of(self, request: StabilitySearch) -> Stability | None:
        """A declared search for the largest step; None where the engine is missing, or the method
        is not meant for the scene. Raises UndeclaredRun."""
        found = looked_up(self.extras, request)
        assert found is None or isinstance(found, Stability)
        return found

    def step_limit(self, scene: str, method: str) -> KnownLimit | None:
        """The smallest limit of the step that is stored of a scene with a method, or None."""
        predicted = self.extras.get(StepPrediction(scene, method))
        measured = self.extras.get(StabilitySearch(scene, method))
        assert predicted is None or isinstance(predicted, PredictedLimits)
        assert measured is None or isinstance(measured, Stability)
        return known_limit(predicted, measured)

    def gradients_of(self, request: GradientSearch) -> Gradients | None:
        """Declared derivatives; None where the engine is missing, or the method is not meant for
        the scene. Raises UndeclaredRun."""
        result = looked_up(self.extras, request)
        assert result is None or isinstance(result, Gradients)
        return result

    def fit(self, request: ParameterFit) -> Identification | None:
        """A declared search for a parameter; None as for `recording`. Raises UndeclaredRun."""
        result = looked_up(self.extras, request)
        assert result is None or isinstance(result, Identification)
        return result

    def long_run_of(self, request: LongRunSearch) -> MeasuredLongRun | None:
        """A declared long run; None as for `stability_of`. Raises UndeclaredRun."""
        result = looked_up(self.extras, request)
        assert result is None or isinstance(result, MeasuredLongRun)
        return result

    def reading(self, request: ModelReading) -> ModelRead | None:
        """The result of a declared reading of a model; None where the engine was not installed.
        Raises UndeclaredRun."""
        found = looked_up(self.extras, request)
        assert found is None or isinstance(found, ModelRead)
        return found


def assembled(head: Study, results: Iterable[TaskResult]) -> Study:
    """A study with these results, its costs in the time of one reference step."""
    parts = tuple(results)
    costs = {}
    for part in parts:
        if part.cost is not None:
            scale = head.reference_step / part.reference_step
            costs[part.pair] = part.cost.scaled(scale) if math.isfinite(scale) else part.cost
    return replace(
        head,
        convergence=tuple(part.convergence for part in parts if part.convergence is not None),
        costs=costs,
        extras=Answers(
            {of: partial(part.extras.__getitem__, of) for part in parts for of in part.extras}
        ),
        analyses=tuple(part.analysis for part in parts if part.analysis is not None),
    )
