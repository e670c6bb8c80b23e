"""The force of a joint's spring, damper and actuators, by the joint's coordinate and velocity."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from plumbob.engines.mechanism import Actuator, Joint, Mechanism

JointForce = Callable[[float, float, Sequence[float]], float]
"""The force on a hinge [N m] or a slide [N] by its coordinate [rad] or [m], its velocity, and the
controls of all actuators."""
Limits = tuple[float, float] | None


def actuators_of(mechanism: Mechanism, joint: int) -> list[Actuator]:
    """The actuators of a joint, by its number."""
    return [actuator for actuator in mechanism.actuators if actuator.joint == joint]


def idle_controls(mechanism: Mechanism) -> list[float]:
    """Controls that are all zero."""
    return [0.0] * (1 + max((actuator.control for actuator in mechanism.actuators), default=-1))


def passive_and_actuator_force(joint: Joint, actuators: Sequence[Actuator]) -> JointForce:
    """The force of these actuators, within the joint's range of forces, and of the joint's spring
    and damper."""
    damping = float(joint.damping[0])
    stiffness = joint.stiffness
    rest = float(joint.rest[0])
    driven = actuator_force(joint, actuators)
    if not actuators:
        return lambda q, rate, controls: -stiffness * (q - rest) - damping * rate
    if not (stiffness or damping):
        return driven
    return lambda q, rate, controls: (
        driven(q, rate, controls) - stiffness * (q - rest) - damping * rate
    )


def actuator_force(joint: Joint, actuators: Sequence[Actuator]) -> JointForce:
    """The force of these actuators, within the joint's range of forces."""
    forces = [_force(actuator) for actuator in actuators]
    limits = joint.force_range
    if len(forces) == 1 and limits is None:
        return forces[0]
    low, high = _ends(limits)

    def force(q: float, rate: float, controls: Sequence[float]) -> float:
        total = sum(exerted(q, rate, controls) for exerted in forces)
        return min(max(total, low), high)

    return force


def _force(actuator: Actuator) -> JointForce:
    """The force of an actuator on its joint."""
    gear = actuator.gear
    gain = actuator.gain
    control = actuator.control
    constant, by_place, by_rate = actuator.bias
    by_place, by_rate = gear * by_place, gear * by_rate
    low, high = _ends(actuator.force_range)
    least, most = _ends(actuator.control_range)

    def force(q: float, rate: float, controls: Sequence[float]) -> float:
        asked = min(max(controls[control], least), most)
        pushed = gain * asked + constant + by_place * q + by_rate * rate
        return gear * min(max(pushed, low), high)

    return force


def _ends(limits: Limits) -> tuple[float, float]:
    """Both limits; infinite where there are none."""
    return limits or (-math.inf, math.inf)
