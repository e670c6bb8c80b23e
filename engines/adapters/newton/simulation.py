"""Scenes in Newton."""

from __future__ import annotations

from plumbob.engines.adapters.newton.stepper import NewtonStepper
from plumbob.engines.adapters.stepped_mechanism import simulated
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Method, Simulation
from plumbob.engines.stepper import State
from plumbob.models.scene import Case


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Build `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""

    def build(mechanism: Mechanism, start: State) -> NewtonStepper:
        return NewtonStepper(mechanism, method.settings, step)

    return simulated(case, step, build)
