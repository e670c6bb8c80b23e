"""Simulations of scenes in PyBullet."""

from __future__ import annotations

from plumbob.engines.adapters.pybullet.client import new_client
from plumbob.engines.adapters.pybullet.stepper import BulletStepper
from plumbob.engines.adapters.stepped_mechanism import simulated
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Method, Simulation
from plumbob.engines.stepper import State, Stepper
from plumbob.models.scene import Case


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """The simulation of a case by a method at `step` [s]; raises Unsupported and ParameterError."""

    def build(mechanism: Mechanism, start: State) -> Stepper:
        return BulletStepper(mechanism, method.settings, step)

    broken = (OverflowError, ValueError, new_client().error)
    return simulated(case, step, build, broken)
