"""Scenes in DART."""

from __future__ import annotations

from functools import partial
from typing import Any

import dartpy

from plumbob.engines.adapters.dart.stepper import DartStepper
from plumbob.engines.adapters.stepped_mechanism import simulated
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Method, Simulation
from plumbob.engines.stepper import State
from plumbob.models.scene import Case


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Build `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""

    tolerance = method.settings.get("tolerance")

    def build(mechanism: Mechanism, start: State) -> DartStepper:
        solver = None if tolerance is None else partial(nsgs, tolerance)
        return DartStepper(mechanism, start, step, solver)

    return simulated(case, step, build)


def nsgs(tolerance: float) -> Any:
    """A solver of contacts with the exact law of friction."""
    solver = dartpy.constraint.NsgsFrictionSolver()
    chosen = solver.getOptions()
    chosen.tolerance = tolerance
    solver.setOptions(chosen)
    return solver
