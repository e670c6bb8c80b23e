"""Scenes in PyBullet."""

from __future__ import annotations

from typing import Any

from plumbob.engines.adapters.stepped_mechanism import simulated
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Method, Simulation
from plumbob.engines.stepper import State, Stepper
from plumbob.models.entry_points import captured
from plumbob.models.scene import Case


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Build `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    from plumbob.engines.adapters.pybullet.stepper import BulletStepper

    def build(mechanism: Mechanism, start: State) -> Stepper:
        return BulletStepper(mechanism, method.settings, step)

    broken = (OverflowError, ValueError, new_client().error)
    return simulated(case, step, build, broken)


def new_client() -> Any:
    """A client of a simulation of its own, which ends with the last reference to it."""
    with captured():  # what its C code prints
        import pybullet
        from pybullet_utils.bullet_client import BulletClient

        return BulletClient(connection_mode=pybullet.DIRECT)
