"""Motors of a mechanism in a Drake diagram. The force of a motor follows a source and, if an
actuator has gains of the joint's coordinate or rate, the plant's state. All forces are computed at
the start of a step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from pydrake.systems.primitives import (
    Adder,
    MatrixGain,
    Saturation,
    TrajectorySource,
    ZeroOrderHold,
)
from pydrake.trajectories import PiecewisePolynomial

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.rotors import moved_inertia
from plumbob.engines.joint_forces import ForceRange, ends, force_of_controls
from plumbob.engines.mechanism import Actuator, Joint, Mechanism

# A rotor that prescribes a motion has the inertia of all that it moves, times such a ratio. With
# the first ratio the rotor's velocity is exact to the last bit. The second is for mechanisms with
# contacts or loops: it is the largest that Drake's solvers handle.
HOLDING, HOLDING_BESIDE_CONSTRAINTS = 1e15, 1e8


@dataclass(frozen=True)
class Motors:
    """The motors of a diagram: a motor on each joint that has an actuator, an armature or a
    prescribed motion."""

    actuators: tuple[Actuator, ...]
    joints: Mapping[int, Joint]  # {number of a joint with a motor: joint}
    held: Mapping[int, float]
    """{number of a joint whose motion is prescribed: inertia of its rotor [kg m^2] or [kg]}."""
    source: Any = None  # source of the forces in the diagram; None if no force is needed

    @property
    def inputs(self) -> int:
        """The number of the source's outputs: one for each actuator, and one for each joint whose
        motion is prescribed."""
        return len(self.actuators) + len(self.held)

    def forces(self, controls: Array | None, times: Array) -> Array:
        """The outputs of the source in each step between these `times` [s], shape (steps, inputs),
        under controls, shape (steps, controls), or under controls that are zero.

        The first columns are for actuators: the part of the force, before the gear, that does not
        depend on the state. The other columns are for joints whose motion is prescribed: the force
        that gives the joint its exact velocity at the end of the step, even if the acceleration
        jumps within the step.
        """
        steps = len(times) - 1
        rows = np.empty((steps, self.inputs))
        for column, motor in enumerate(self.actuators):
            # Drake's coordinate is 0 in the reference pose. The plant's gain multiplies bias[1] by
            # gear times Drake's coordinate. The part for the reference coordinate, bias[1] * gear *
            # reference, is added here.
            reference_length = motor.gear * float(self.joints[motor.joint].reference[0])
            reference_force = motor.bias[1] * reference_length
            rows[:, column] = force_of_controls(motor, controls, steps) + reference_force
        for column, (number, inertia) in enumerate(self.held.items(), len(self.actuators)):
            velocity = self.joints[number].velocity
            assert velocity is not None
            rows[:, column] = inertia * np.diff(velocity(times)) / np.diff(times)
        return rows


def add_motors(mechanism: Mechanism, plant: Any, joints: Sequence[Any]) -> Motors:
    """Adds the motors of a mechanism to its plant. The inertia of a rotor is the armature of its
    joint. If the motion of the joint is prescribed, the inertia is so large that the rotor imposes
    the motion."""
    driven = {actuator.joint for actuator in mechanism.actuators}
    joints_with_motor = dict[int, Joint]()
    held = dict[int, float]()
    for number, joint in enumerate(mechanism.joints):
        inertia = float(joint.armature[0])
        if joint.velocity is not None:
            inertia = _holding_inertia(mechanism, joint)
            held[number] = inertia
        if number in driven or inertia:
            joints_with_motor[number] = joint
            motor = plant.AddJointActuator(f"motor_{number}", joints[number])
            motor.set_default_rotor_inertia(inertia)
            motor.set_default_gear_ratio(1.0)
    return Motors(mechanism.actuators, joints_with_motor, held)


def _holding_inertia(mechanism: Mechanism, joint: Joint) -> float:
    """The inertia of a rotor that imposes the motion of a joint [kg m^2] or [kg]."""
    ratio = HOLDING_BESIDE_CONSTRAINTS if mechanism.touching or mechanism.loops else HOLDING
    return ratio * moved_inertia(mechanism, joint.kind)


def connected_motors(
    builder: Any, plant: Any, motors: Motors, joints: Sequence[Any], control: float
) -> Motors:
    """The motors with a source, which this function connects to the finished plant. If the
    plant is continuous and motions are prescribed, the source's outputs are held for `control` [s];
    Drake then ends a step whenever an output changes."""
    if not motors.inputs:
        return motors
    no_forces = held_forces(np.zeros((1, motors.inputs)), [0, 1])
    source = builder.AddSystem(TrajectorySource(no_forces))
    forces = source.get_output_port()
    if motors.held and not plant.time_step():
        forces = _output(builder, forces, ZeroOrderHold(control, motors.inputs))
    gains = _feedback_gains(plant, motors, joints)
    if gains.any():
        feedback = _output(builder, plant.get_state_output_port(), MatrixGain(gains))
        adder = builder.AddSystem(Adder(2, motors.inputs))
        builder.Connect(forces, adder.get_input_port(0))
        builder.Connect(feedback, adder.get_input_port(1))
        forces = adder.get_output_port()
    ranges: list[ForceRange] = [actuator.force_range for actuator in motors.actuators]
    ranges += [None] * len(motors.held)
    forces = _clamped(builder, forces, ranges)
    gears = _gears(motors)
    if not np.array_equal(gears, np.eye(len(gears))):
        forces = _output(builder, forces, MatrixGain(gears))
    joint_ranges = [joint.force_range for joint in motors.joints.values()]
    forces = _clamped(builder, forces, joint_ranges)
    builder.Connect(forces, plant.get_actuation_input_port())
    return replace(motors, source=source)


def _feedback_gains(plant: Any, motors: Motors, joints: Sequence[Any]) -> Array:
    """The derivatives of the motors' forces, before the gears, by the plant's state, shape (inputs,
    states)."""
    gains = np.zeros((motors.inputs, plant.num_multibody_states()))
    for row, motor in enumerate(motors.actuators):
        joint = joints[motor.joint]
        gains[row, joint.position_start()] = motor.gear * motor.bias[1]
        rate = plant.num_positions() + joint.velocity_start()
        gains[row, rate] = motor.gear * motor.bias[2]
    return gains


def _gears(motors: Motors) -> Array:
    """The matrix that takes the outputs of the source to the forces on the joints with a motor,
    shape (joints, inputs)."""
    numbers = list(motors.joints)
    gears = np.zeros((len(numbers), motors.inputs))
    for column, motor in enumerate(motors.actuators):
        gears[numbers.index(motor.joint), column] = motor.gear
    for column, number in enumerate(motors.held, start=len(motors.actuators)):
        gears[numbers.index(number), column] = 1.0
    return gears


def _output(builder: Any, port: Any, system: Any) -> Any:
    """Adds a system whose input is an output port; returns the output port of the system."""
    added = builder.AddSystem(system)
    builder.Connect(port, added.get_input_port(0))
    return added.get_output_port(0)


def _clamped(builder: Any, port: Any, limits: Sequence[ForceRange]) -> Any:
    """A port with the values of `port`, each clamped to its limits. If there are no limits, it is
    `port` itself."""
    if not any(limits):
        return port
    low, high = np.array([ends(pair) for pair in limits]).T
    return _output(builder, port, Saturation(low, high))


def held_forces(rows: Array, times: Sequence[float] | Array) -> Any:
    """Drake's trajectory of forces: each row of forces is held from one of the `times` [s] to the
    next."""
    return PiecewisePolynomial.ZeroOrderHold(times, np.vstack([rows, rows[-1:]]).T)
