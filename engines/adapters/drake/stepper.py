"""A mechanism as a discrete plant of Drake steps it.

Drake's step is semi-implicit Euler, with implicit dampers and explicit springs of joints. An
attitude is a quaternion, which a step moves along its tangent by the new angular velocity.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pydrake.math import RollPitchYaw, RotationMatrix
from pydrake.systems.analysis import Simulator

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.drake.builder import build
from plumbob.engines.adapters.drake.motors import held_forces
from plumbob.engines.adapters.joints import joint_places, with_latest_signs
from plumbob.engines.adapters.step_clock import StepClock
from plumbob.engines.mechanism import Joint, Mechanism
from plumbob.engines.method import Options
from plumbob.engines.peer_model import rotation
from plumbob.engines.stepper import State


class DrakeStepper:
    """A mechanism in a Drake plant with these settings, which takes steps of `step` [s] from any
    state. The settings include the plant's time step [s]. If that is 0, the plant is continuous,
    and forces of the source are held for `control` [s]."""

    def __init__(
        self, mechanism: Mechanism, settings: Options, step: float, control: float = 0.0
    ) -> None:
        self.step = step
        self.built = build(mechanism, settings, control)
        self.mechanism = mechanism
        self._new_context = self.built.diagram.CreateDefaultContext()
        self.simulator = simulator_of(self.built.diagram, self._new_context.Clone())
        self._plant_context = self.built.plant_context(self.simulator.get_mutable_context())
        self._clock = StepClock(step)
        self._latest = State(np.zeros(0), np.zeros(0))  # state that was put or read last

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state, at a time [s]."""
        self._clock.restart(time)
        self._latest = state
        context = self.simulator.get_mutable_context()
        context.SetTimeStateAndParametersFrom(self._new_context)
        plant = self.built.plant
        q = np.zeros(plant.num_positions())
        v = np.zeros(plant.num_velocities())
        places = joint_places(self.mechanism.joints)
        for joint, drake_joint, (place, place_of_rates) in zip(
            self.mechanism.joints, self.built.joints, places, strict=True
        ):
            drake_place, drake_place_of_rates = _places_in_drake(drake_joint)
            q[drake_place], v[drake_place_of_rates] = _to_drake(
                joint, state.qpos[place], state.qvel[place_of_rates]
            )
        plant.SetPositions(self._plant_context, q)
        plant.SetVelocities(self._plant_context, v)
        self.simulator.Initialize()

    def state(self) -> State:
        """The present state. The sign of a quaternion is the sign that is nearer to the quaternion
        that was put or read last."""
        q = self.built.plant.GetPositions(self._plant_context)
        v = self.built.plant.GetVelocities(self._plant_context)
        positions = list[Array]()
        velocities = list[Array]()
        for joint, drake_joint in zip(self.mechanism.joints, self.built.joints, strict=True):
            place, place_of_rates = _places_in_drake(drake_joint)
            position, rates = _from_drake(joint, q[place], v[place_of_rates])
            positions.append(position)
            velocities.append(rates)
        unsigned = np.concatenate(positions)
        qpos = with_latest_signs(self.mechanism.joints, unsigned, self._latest.qpos)
        self._latest = State(qpos, np.concatenate(velocities))
        return self._latest

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps under controls, shape (steps, controls), or with controls that are
        zero."""
        self.drive(controls, steps)
        self._clock.steps_taken += steps
        advance(self.simulator, self._clock.steps_taken, self.step)

    def drive(self, controls: Array | None, steps: int) -> None:
        """Gives the source its outputs in the next `steps` steps under controls, shape (steps,
        controls), or with controls that are zero."""
        motors = self.built.motors
        if motors.source is not None:
            forces = motors.forces(controls, self._clock.next_times(steps))
            numbers = self._clock.next_numbers(steps)
            # The source's outputs change half a step before each step begins: no output changes at
            # a time at which Drake reads it.
            motors.source.UpdateTrajectory(held_forces(forces, self.step * (numbers - 0.5)))


def simulator_of(diagram: Any, context: Any) -> Any:
    """A simulator of a diagram, initialised from a context."""
    simulator = Simulator(diagram, context)
    simulator.set_target_realtime_rate(0.0)
    simulator.Initialize()
    return simulator


def advance(simulator: Any, steps: int, step: float) -> None:
    """Advances a simulator until it has taken `steps` steps of `step` [s] since the time 0."""
    # A discrete update takes place at the time at which its step begins. The simulator stops half a
    # step before the next update, so that rounding cannot decide whether the update is done.
    simulator.AdvanceTo((steps - 0.5) * step)


def _places_in_drake(drake_joint: Any) -> tuple[slice, slice]:
    """The place of a joint's coordinates among Drake's positions, and the place of the joint's
    rates among Drake's velocities."""
    first = drake_joint.position_start()
    first_rate = drake_joint.velocity_start()
    place = slice(first, first + drake_joint.num_positions())
    return place, slice(first_rate, first_rate + drake_joint.num_velocities())


def _to_drake(joint: Joint, position: Array, rates: Array) -> tuple[Array, Array]:
    """Drake's coordinates and rates of a joint, from MuJoCo's. Drake has the angular velocity along
    the axes of the body above: for a free joint, the world."""
    if joint.kind == "free":
        attitude = position[3:]
        drake_rates = np.concatenate([rotation(attitude) @ rates[3:], rates[:3]])
        return np.concatenate([attitude, position[:3]]), drake_rates
    if joint.kind == "ball":
        turn = rotation(position)
        return RollPitchYaw(RotationMatrix(turn)).vector(), turn @ rates
    return position - joint.reference, rates


def _from_drake(joint: Joint, position: Array, rates: Array) -> tuple[Array, Array]:
    """MuJoCo's coordinates and rates of a joint, from Drake's. A quaternion may have either
    sign."""
    if joint.kind == "free":
        attitude = _normalised(position[:4])
        body_rates = np.concatenate([rates[3:], rotation(attitude).T @ rates[:3]])
        return np.concatenate([position[4:], attitude]), body_rates
    if joint.kind == "ball":
        turn = RollPitchYaw(position)
        attitude = _normalised(turn.ToQuaternion().wxyz())
        return attitude, turn.ToRotationMatrix().matrix().T @ rates
    return position + joint.reference, rates


def _normalised(attitude: Array) -> Array:
    """The quaternion `attitude` with a length of 1."""
    return attitude / math.sqrt(attitude @ attitude)
