"""Motors of a mechanism in a Drake diagram. The force of a motor follows a source and, if an
actuator has gains of the joint's coordinate or rate, the plant's state. All forces are computed at
the start of a step."""

from __future__ import annotations

import math
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
from plumbob.engines.mechanism import Actuator, Joint, Mechanism

# A rotor that prescribes a motion has the inertia of all that it moves, times such a ratio. With
# the first ratio the rotor's velocity is exact to the last bit. The second is for mechanisms with
# contacts or loops: it is the largest that Drake's solvers handle.
HOLDING, HOLDING_BESIDE_CONSTRAINTS = 1e15, 1e8


Range = tuple[float, float] | None


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
            control = np.zeros(steps) if controls is None else controls[:, motor.control]
            force = motor.gain * np.clip(control, *_ends(motor.control_range)) + motor.bias[0]
            # Drake's coordinate is 0 in the drawing: the gain acts on that coordinate, and the
            # contribution of the drawing's coordinate is added here.
            drawn = motor.gear * float(self.joints[motor.joint].reference[0])
            rows[:, column] = force + motor.bias[1] * drawn
        for column, (number, inertia) in enumerate(self.held.items(), len(self.actuators)):
            velocity = self.joints[number].velocity
            assert velocity is not None
            rows[:, column] = inertia * np.diff(velocity(times)) / np.diff(times)
        return rows


def _ends(limits: Range) -> tuple[float, float]:
    """The lower and the upper limit; infinite if there are none."""
    return limits or (-math.inf, math.inf)


def motors(mechanism: Mechanism, plant: Any, joints: Sequence[Any]) -> Motors:
    """Adds the motors of a mechanism to its plant. The inertia of a rotor is the armature of its
    joint. If the motion of the joint is prescribed, the inertia is so large that the rotor imposes
    the motion."""
    driven = {actuator.joint for actuator in mechanism.actuators}
    moved = dict[int, Joint]()
    held = dict[int, float]()
    for number, joint in enumerate(mechanism.joints):
        inertia = float(joint.armature[0])
        if joint.velocity is not None:
            inertia = held[number] = _holding(mechanism, joint)
        if number in driven or inertia:
            moved[number] = joint
            motor = plant.AddJointActuator(f"motor_{number}", joints[number])
            motor.set_default_rotor_inertia(inertia)
            motor.set_default_gear_ratio(1.0)
    return Motors(mechanism.actuators, moved, held)


def _holding(mechanism: Mechanism, joint: Joint) -> float:
    """The inertia of a rotor that imposes the motion of a joint [kg m^2] or [kg]."""
    ratio = HOLDING_BESIDE_CONSTRAINTS if mechanism.touching or mechanism.loops else HOLDING
    return ratio * moved_inertia(mechanism, joint.kind)


def connected(
    builder: Any, plant: Any, driven: Motors, joints: Sequence[Any], control: float
) -> Motors:
    """The motors `driven` with a source, which this function connects to the finished plant. If the
    plant is continuous and motions are prescribed, the source's outputs are held for `control` [s];
    Drake then ends a step whenever an output changes."""
    if not driven.inputs:
        return driven
    source = builder.AddSystem(
        TrajectorySource(held_forces(np.zeros((1, driven.inputs)), [0, 1]))
    )
    forces = source.get_output_port()
    if driven.held and not plant.time_step():
        forces = _after(builder, forces, ZeroOrderHold(control, driven.inputs))
    gains = np.zeros((driven.inputs, plant.num_multibody_states()))
    for row, motor in enumerate(driven.actuators):
        joint = joints[motor.joint]
        gains[row, joint.position_start()] = motor.gear * motor.bias[1]
        rate = plant.num_positions() + joint.velocity_start()
        gains[row, rate] = motor.gear * motor.bias[2]
    if gains.any():
        feedback = _after(builder, plant.get_state_output_port(), MatrixGain(gains))
        adder = builder.AddSystem(Adder(2, driven.inputs))
        builder.Connect(forces, adder.get_input_port(0))
        builder.Connect(feedback, adder.get_input_port(1))
        forces = adder.get_output_port()
    ranges: list[Range] = [x.force_range for x in driven.actuators]
    forces = _within(builder, forces, [*ranges, *[None] * len(driven.held)])
    numbers = list(driven.joints)
    on_joints = np.zeros((len(numbers), driven.inputs))
    for column, motor in enumerate(driven.actuators):
        on_joints[numbers.index(motor.joint), column] = motor.gear
    for column, number in enumerate(driven.held, start=len(driven.actuators)):
        on_joints[numbers.index(number), column] = 1.0
    if not np.array_equal(on_joints, np.eye(len(on_joints))):
        forces = _after(builder, forces, MatrixGain(on_joints))
    forces = _within(builder, forces, [x.force_range for x in driven.joints.values()])
    builder.Connect(forces, plant.get_actuation_input_port())
    return replace(driven, source=source)


def _after(builder: Any, port: Any, system: Any) -> Any:
    """Adds a system whose input is an output port; returns the output port of the system."""
    added = builder.AddSystem(system)
    builder.Connect(port, added.get_input_port(0))
    return added.get_output_port(0)


def _within(builder: Any, port: Any, limits: Sequence[Range]) -> Any:
    """A port with the values of `port`, each clamped to its limits. If there are no limits, it is
    `port` itself."""
    if not any(limits):
        return port
    low, high = np.array([_ends(pair) for pair in limits]).T
    return _after(builder, port, Saturation(low, high))


def held_forces(rows: Array, times: Sequence[float] | Array) -> Any:
    """Drake's trajectory of forces: each row of forces is held from one of the `times` [s] to the
    next."""
    return PiecewisePolynomial.ZeroOrderHold(times, np.vstack([rows, rows[-1:]]).T)
