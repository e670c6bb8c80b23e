"""Simulations of scenes in Newton."""

from __future__ import annotations

from functools import lru_cache

from plumbob.engines.adapters.newton.builder import Built, SolverName, build
from plumbob.engines.adapters.newton.stepper import NewtonStepper
from plumbob.engines.adapters.stepped_mechanism import compiled_scene, simulated
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Method, Simulation
from plumbob.engines.stepper import State
from plumbob.models.scene import Case


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """The simulation of a case by a method at `step` [s]; raises Unsupported and ParameterError."""

    def stepper(mechanism: Mechanism, start: State) -> NewtonStepper:
        """The stepper of the case, whose mechanism is built once for all steps."""
        built = _cached_build(_CaseKey(case), method.settings["solver"])
        return NewtonStepper(built, method.settings, step)

    return simulated(case, step, stepper)


class _CaseKey:
    """A case as a key of a cache. Cases have no hash: a key is equal to a key with the same case
    object."""

    def __init__(self, case: Case) -> None:
        self.case = case

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _CaseKey) and other.case is self.case

    def __hash__(self) -> int:
        return id(self.case)


@lru_cache(maxsize=4)  # setting up the detection of contacts takes half a second
def _cached_build(key: _CaseKey, solver: SolverName) -> Built:
    """The model of a case, for runs at all steps. Several models are kept, because the costs of
    several methods are timed in turns."""
    return build(compiled_scene(key.case).mechanism, solver)
