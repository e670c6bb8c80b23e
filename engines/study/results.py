"""What a study found: convergence of each method on each scene, costs, and the extra runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from plumbob.engines.method import Method, Trimming
from plumbob.engines.study.convergence import SEED, ConvergenceStudy
from plumbob.engines.study.cost import Cost, Key
from plumbob.engines.study.extra_runs import (
    ExtraConvergence,
    ExtraRun,
    Request,
    Result,
    TrimmingRun,
    looked_up,
)
from plumbob.engines.study.model_reading import ModelRead, ModelReading
from plumbob.engines.study.provenance import Provenance
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import case_of, system_of
from plumbob.models.scene import Observable, Quantity, Scene

Observables = tuple[Observable, ...]
Quantities = tuple[Quantity, ...]


@dataclass(frozen=True)
class Study:
    """Everything that was measured: errors of each method on each scene, costs, extra runs."""

    profile: str  # "quick" or "full"
    scenes: tuple[Scene, ...]
    methods: tuple[Method, ...]
    convergence: tuple[ConvergenceStudy, ...]
    costs: Mapping[Key, Cost]
    reference_step: float  # [ns] of a bare step of an empty model, in this study
    seconds: Mapping[str, float]  # wall time of the two halves, "errors" and "costs"
    observed: Mapping[str, Observables] = field(default_factory=dict)
    """The observables of each scene, so that a reader need not load every system."""
    interest: Mapping[str, Quantities] = field(default_factory=dict)
    """The quantities of interest of each scene, likewise."""
    extras: Mapping[Request, Result] = field(default_factory=dict)  # what findings declared
    provenance: Provenance = field(default_factory=Provenance)
    seed: int = SEED  # that drew one more step for each pair

    def observables(self, scene: str) -> Observables:
        """The observables of a scene, the leading one first."""
        if scene in self.observed:
            return self.observed[scene]
        return system_of(next(s for s in self.scenes if s.name == scene)).observables

    def quantities(self, scene: str) -> Quantities:
        """What a scene is about: observables with scales, the most telling one first."""
        if scene in self.interest:
            return self.interest[scene]
        case = case_of(next(s for s in self.scenes if s.name == scene))
        return case.system.quantities(case)

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

    def reading(self, request: ModelReading) -> ModelRead | None:
        """What a declared reading of a model gave; None where the engine was not installed. Raises
        UndeclaredRun."""
        found = looked_up(self.extras, request)
        assert found is None or isinstance(found, ModelRead)
        return found
