"""The force of a joint's spring, damper and actuators, by the joint's coordinate and velocity."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.mechanism import Actuator, Joint, Mechanism

JointForce = Callable[[float, float, Sequence[float]], float]
"""The force on a hinge [N m] or a slide [N] by its coordinate [rad] or [m], its velocity, and the
controls of all actuators."""
ForceRange = tuple[float, float] | None


def actuators_of(mechanism: Mechanism, joint: int) -> list[Actuator]:
    """The actuators that act on the joint with this number."""
    return [actuator for actuator in mechanism.actuators if actuator.joint == joint]


def idle_controls(mechanism: Mechanism) -> list[float]:
    """A list of zeros, one for each control of a mechanism."""
    return [0.0] * (1 + max((actuator.control for actuator in mechanism.actuators), default=-1))


def passive_and_actuator_force(joint: Joint, actuators: Sequence[Actuator]) -> JointForce:
    """The force of a joint's actuators, clamped to the joint's range of forces, plus the force of
    the joint's spring and damper."""
    damping = float(joint.damping[0])
    stiffness = joint.stiffness
    coordinate_at_rest = float(joint.rest[0])
    driven = actuator_force(joint, actuators)
    if not actuators:
        return lambda q, rate, controls: -stiffness * (q - coordinate_at_rest) - damping * rate
    if not (stiffness or damping):
        return driven
    return lambda q, rate, controls: (
        driven(q, rate, controls) - stiffness * (q - coordinate_at_rest) - damping * rate
    )


def actuator_force(joint: Joint, actuators: Sequence[Actuator]) -> JointForce:
    """The sum of the forces of a joint's actuators, clamped to the joint's range of forces."""
    forces = [_force(actuator) for actuator in actuators]
    limits = joint.force_range
    if len(forces) == 1 and limits is None:
        return forces[0]
    low, high = ends(limits)

    def force(q: float, rate: float, controls: Sequence[float]) -> float:
        """The sum of the forces, clamped to the joint's range."""
        total = sum(exerted(q, rate, controls) for exerted in forces)
        return min(max(total, low), high)

    return force


def _force(actuator: Actuator) -> JointForce:
    """The force of one actuator on its joint, clamped to the actuator's ranges."""
    gear = actuator.gear
    gain = actuator.gain
    control = actuator.control
    constant, bias_per_length, bias_per_rate = actuator.bias
    bias_per_coordinate = gear * bias_per_length
    bias_per_velocity = gear * bias_per_rate
    low, high = ends(actuator.force_range)
    least, most = ends(actuator.control_range)

    def force(q: float, rate: float, controls: Sequence[float]) -> float:
        """The force of the actuator times its gear."""
        clamped_control = min(max(controls[control], least), most)
        unclamped = gain * clamped_control + constant + bias_per_coordinate * q
        unclamped += bias_per_velocity * rate
        return gear * min(max(unclamped, low), high)

    return force


def force_of_controls(actuator: Actuator, controls: Array | None, steps: int) -> Array:
    """The part of an actuator's force that does not depend on the joint, before the gear multiplies
    it, in each of `steps` steps, shape (steps,). It is under controls, shape (steps, controls), or
    under controls that are zero."""
    control = np.zeros(steps) if controls is None else controls[:, actuator.control]
    clamped_control = np.clip(control, *ends(actuator.control_range))
    return np.asarray(actuator.gain * clamped_control + actuator.bias[0])


def ends(limits: ForceRange) -> tuple[float, float]:
    """The lower and the upper limit; infinite if there are none."""
    return limits or (-math.inf, math.inf)
