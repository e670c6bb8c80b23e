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
from plumbob.engines.adapters.drake.builder import Built, build
from plumbob.engines.adapters.drake.motors import held_forces
from plumbob.engines.adapters.joints import joint_places, nearer_attitude
from plumbob.engines.mechanism import Joint, Mechanism
from plumbob.engines.method import Options
from plumbob.engines.peer_model import rotation
from plumbob.engines.stepper import Forces, State


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
        self._fresh = self.built.diagram.CreateDefaultContext()
        self.simulator = simulator_of(self.built.diagram, self._fresh.Clone())
        self._plant_context = self.built.plant_context(self.simulator.get_mutable_context())
        self._start_time = 0.0  # [s]
        self._steps_taken = 0
        self._latest = State(np.zeros(0), np.zeros(0))

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state, at a time [s]."""
        self._start_time = time
        self._steps_taken = 0
        self._latest = state
        context = self.simulator.get_mutable_context()
        context.SetTimeStateAndParametersFrom(self._fresh)
        put(self.mechanism, self.built, self._plant_context, state)
        self.simulator.Initialize()

    def state(self) -> State:
        """The present state. The sign of a quaternion is the sign that is nearer to the quaternion
        that was put or read last."""
        self._latest = present_state(
            self.mechanism, self.built, self._plant_context, self._latest
        )
        return self._latest

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps under controls, shape (steps, controls), or with controls that are
        zero."""
        self.drive(controls, steps)
        self._steps_taken += steps
        advance(self.simulator, self._steps_taken, self.step)

    def drive(self, controls: Array | None, steps: int) -> None:
        """Gives the source its outputs in the next `steps` steps under controls, shape (steps,
        controls), or with controls that are zero."""
        motors = self.built.motors
        if motors.source is not None:
            numbers = np.arange(
                self._steps_taken, self._steps_taken + steps + 1, dtype=np.float64
            )
            forces = motors.forces(controls, self._start_time + self.step * numbers)
            # The source's outputs change half a step before each step begins: no output changes at
            # a time at which Drake reads it.
            motors.source.UpdateTrajectory(held_forces(forces, self.step * (numbers - 0.5)))

    def forces(self) -> Forces:
        """The contact forces of the last step. The forces of joints are not read: they are nan."""
        touching = np.full((len(self.mechanism.touching), 3), math.nan)
        if self._steps_taken:
            touching[:] = 0.0
            port = self.built.plant.get_contact_results_output_port()
            results = port.Eval(self._plant_context)
            for i in range(results.num_point_pair_contacts()):
                contact = results.point_pair_contact_info(i)
                pair = contact.point_pair()
                number, sign = self.built.touching[pair.id_A, pair.id_B]
                touching[number] += sign * contact.contact_force()  # force on the second body
        return Forces(np.full((len(self.mechanism.joints), 3), math.nan), touching)


def simulator_of(diagram: Any, context: Any) -> Any:
    """A simulator of a diagram, initialised from a context."""
    simulator = Simulator(diagram, context)
    simulator.set_target_realtime_rate(0.0)
    simulator.Initialize()
    return simulator


def advance(simulator: Any, taken: int, step: float) -> None:
    """Advances a simulator until it has taken `taken` steps of `step` [s] since the time 0."""
    # A discrete update takes place at the time at which its step begins. The simulator stops half a
    # step before the next update, so that rounding cannot decide whether the update is done.
    simulator.AdvanceTo((taken - 0.5) * step)


def put(mechanism: Mechanism, built: Built, plant_context: Any, state: State) -> None:
    """Sets the state of a plant in the plant's context."""
    q = np.zeros(built.plant.num_positions())
    v = np.zeros(built.plant.num_velocities())
    places = joint_places(mechanism.joints)
    for joint, drake_joint, (place, place_of_rates) in zip(
        mechanism.joints, built.joints, places, strict=True
    ):
        position = state.qpos[place]
        rates = state.qvel[place_of_rates]
        drake_position, drake_rates = _to_drake(joint, position, rates)
        drake_place, drake_place_of_rates = _places_in_drake(drake_joint)
        q[drake_place] = drake_position
        v[drake_place_of_rates] = drake_rates
    built.plant.SetPositions(plant_context, q)
    built.plant.SetVelocities(plant_context, v)


def present_state(
    mechanism: Mechanism, built: Built, plant_context: Any, latest: State
) -> State:
    """The state of a plant from the plant's context. The sign of each quaternion is the sign that
    is nearer to the quaternion in the `latest` state."""
    q = built.plant.GetPositions(plant_context)
    v = built.plant.GetVelocities(plant_context)
    positions = list[Array]()
    velocities = list[Array]()
    places = joint_places(mechanism.joints)
    for joint, drake_joint, (place, _) in zip(
        mechanism.joints, built.joints, places, strict=True
    ):
        drake_place, drake_place_of_rates = _places_in_drake(drake_joint)
        latest_position = latest.qpos[place]
        position, rates = _from_drake(
            joint, q[drake_place], v[drake_place_of_rates], latest_position
        )
        positions.append(position)
        velocities.append(rates)
    return State(np.concatenate(positions), np.concatenate(velocities))


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


def _from_drake(
    joint: Joint, position: Array, rates: Array, latest: Array
) -> tuple[Array, Array]:
    """MuJoCo's coordinates and rates of a joint, from Drake's. The sign of a quaternion is the sign
    that is nearer to the quaternion in the `latest` coordinates."""
    if joint.kind == "free":
        attitude = nearer_attitude(_normalised(position[:4]), latest[3:])
        body_rates = np.concatenate([rates[3:], rotation(attitude).T @ rates[:3]])
        return np.concatenate([position[4:], attitude]), body_rates
    if joint.kind == "ball":
        turn = RollPitchYaw(position)
        attitude = nearer_attitude(_normalised(turn.ToQuaternion().wxyz()), latest)
        return attitude, turn.ToRotationMatrix().matrix().T @ rates
    return position + joint.reference, rates


def _normalised(attitude: Array) -> Array:
    """The quaternion `attitude` with a length of 1."""
    return attitude / math.sqrt(attitude @ attitude)
