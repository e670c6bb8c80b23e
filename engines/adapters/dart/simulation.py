"""Simulations of scenes in DART."""

from __future__ import annotations

from functools import partial
from typing import Any

import dartpy

from plumbob.engines.adapters.dart.stepper import DartStepper
from plumbob.engines.adapters.stepped_mechanism import simulated
from plumbob.engines.adapters.stepping import SteppedSimulation
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Method, Simulation
from plumbob.engines.stepper import State
from plumbob.engines.trajectory import Trajectory
from plumbob.models.entry_points import captured
from plumbob.models.scene import Case


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """The simulation of a case by a method at `step` [s]; raises Unsupported and ParameterError."""
    tolerance = method.settings.get("tolerance")

    def build(mechanism: Mechanism, start: State) -> DartStepper:
        """The stepper of a mechanism, with the method's solver of contacts."""
        solver = None if tolerance is None else partial(nsgs, tolerance)
        return DartStepper(mechanism, start, step, solver)

    return DartSimulation(**vars(simulated(case, step, build)))


class DartSimulation(SteppedSimulation):
    """A scene in DART. Lines that DART prints are dropped: there are several lines a step once
    numbers are no longer finite."""

    def run(self) -> Trajectory:
        """Runs from the start to the end, or until the run diverges."""
        with captured():
            return super().run()


def nsgs(tolerance: float) -> Any:
    """DART's NSGS solver of contacts, which has Coulomb's law of friction, at a tolerance."""
    solver = dartpy.constraint.NsgsFrictionSolver()
    options = solver.getOptions()
    options.tolerance = tolerance
    solver.setOptions(options)
    return solver
