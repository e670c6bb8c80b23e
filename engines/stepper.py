"""The protocol of a stepper: a mechanism in an engine, which takes steps from any given state."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.mechanism import Mechanism
from plumbob.models.model_file import Controls, Feedback

StepDerivatives = tuple[Array, Array]
"""The derivatives of the state after one step in tangent coordinates: by the state before it, shape
(m, m), and by the control, shape (m, controls)."""


@dataclass(frozen=True)
class State:
    """A state of a mechanism in MuJoCo's coordinates. A hinge or a slide has one position, a ball a
    quaternion, a free body its place and a quaternion for its attitude; quaternions have the scalar
    first. The velocities of a free body are the velocity of its frame in the world and its angular
    velocity in its own axes."""

    qpos: Array  # [m], [rad], quaternions, shape (nq,)
    qvel: Array  # [m/s], [rad/s], shape (nv,)
    # Activations of actuators, shape (na,)
    act: Array = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True)
class Forces:
    """The forces of an engine in its last step [N], along the world's axes. A force is NaN before
    the first step, and if the engine does not report it."""

    joints: Array  # force [N] of each joint on the body that the joint moves, shape (joints, 3)
    touching: Array  # force [N] of a pair's first shape on the second, shape (pairs, 3)


@dataclass(frozen=True)
class SceneMechanism:
    """The mechanism of a scene, its start, and the controls of its actuators."""

    mechanism: Mechanism
    start: State
    controls: Controls | Feedback | None  # None: the controls stay zero


@dataclass(frozen=True)
class EndDerivatives:
    """The positions and velocities at the end of a run of a tree of hinges and slides, with their
    derivatives by one number."""

    qpos: Array  # [m], [rad], shape (n,)
    by_qpos: Array
    qvel: Array  # [m/s], [rad/s], shape (n,)
    by_qvel: Array


class Diverged(Exception):
    """The engine reports that a stepper's state is no longer finite."""


class Stepper(Protocol):
    """A mechanism in an engine at a time step."""

    @property
    def step(self) -> float:
        """The time step [s]."""

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state, at a time [s]. Nothing of earlier steps remains: no impulse with which a
        solver would begin, and no sleeping body."""

    def state(self) -> State:
        """Returns the present state."""

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps under controls, shape (steps, controls); each row is held for a step.
        The controls are None if the mechanism uses no actuator."""


@runtime_checkable
class TellsStepDerivatives(Protocol):
    """A stepper of an engine that computes the derivatives of its own steps."""

    # Name of the way to the derivatives of a run that multiplies those of its steps
    own_way: str

    def own_step_derivatives(self, controls: Array) -> Iterator[StepDerivatives]:
        """Yields the derivatives of each step from the present state on under controls, shape
        (steps, controls), while the step is taken."""


@runtime_checkable
class TellsForces(Protocol):
    """A stepper of an engine that reports forces."""

    def forces_of_last_step(self) -> Forces:
        """Returns the forces of the last step."""
