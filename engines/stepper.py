"""A stepper: a mechanism in an engine, which takes steps from any state that it is put into."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.mechanism import Mechanism
from plumbob.models.model_file import Controls

StepDerivatives = tuple[Array, Array]
"""The derivatives of the state after one step in tangent coordinates: by the state before it, shape
(m, m), and by the control, shape (m, controls)."""


@dataclass(frozen=True)
class State:
    """A state of a mechanism in MuJoCo's coordinates: a hinge or a slide has one position, a ball a
    quaternion, a free body its place and its attitude, a quaternion, scalar first. A free body's
    velocities are its frame's in the world and its angular velocity in its own axes."""

    qpos: Array  # [m], [rad], quaternions, shape (nq,)
    qvel: Array  # [m/s], [rad/s], shape (nv,)
    act: Array = field(default_factory=lambda: np.zeros(0))  # of actuators, shape (na,)


@dataclass(frozen=True)
class Forces:
    """Forces of an engine in the last step that it took [N], along the world's axes. Where nothing
    has been stepped yet, or the engine does not tell a force, it is nan."""

    joints: Array  # force [N] of each joint on the body that the joint moves, shape (joints, 3)
    touching: Array  # force [N] of a pair's first shape on the second, shape (pairs, 3)


@dataclass(frozen=True)
class SceneMechanism:
    """The mechanism of a scene, its start, and the controls of its actuators."""

    mechanism: Mechanism
    start: State
    controls: Controls | None  # None: they stay zero


@dataclass(frozen=True)
class EndDerivatives:
    """The positions and velocities at the end of a run of a tree of hinges and slides, with their
    derivatives by one number."""

    qpos: Array  # [m], [rad], shape (n,)
    by_qpos: Array
    qvel: Array  # [m/s], [rad/s], shape (n,)
    by_qvel: Array


class Diverged(Exception):
    """A stepper's state is no longer finite, as its engine has noticed."""


class Stepper(Protocol):
    """A mechanism in an engine at a time step."""

    @property
    def step(self) -> float:
        """[s]"""

    def put(self, state: State, time: float = 0.0) -> None:
        """Set the state, at a time [s]. Nothing of the steps before survives: no impulse that a
        solver would begin with, no body that sleeps."""

    def state(self) -> State:
        """The state now."""

    def advance(self, controls: Array | None, steps: int) -> None:
        """Take `steps` steps under controls, shape (steps, controls): a row is held for a step.
        None where the mechanism has no actuator that is used."""


@runtime_checkable
class TellsStepDerivatives(Protocol):
    """A stepper of an engine that has derivatives of its own steps."""

    own_way: str  # name of the way to the derivatives of a run that multiplies them

    def own_step_derivatives(self, controls: Array) -> Iterator[StepDerivatives]:
        """The derivatives of each step from the state now on under controls, shape (steps,
        controls), as that step is taken."""


@runtime_checkable
class TellsForces(Protocol):
    """A stepper of an engine that tells forces."""

    def forces(self) -> Forces:
        """The forces of the last step."""
