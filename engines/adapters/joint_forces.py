"""Forces of joints: springs, dampers and actuators."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from plumbob.engines.mechanism import Actuator, Joint

Effort = Callable[[float, float, Sequence[float]], float]
"""The force of a joint's actuators and of its spring and damper [N] or [N m] by its coordinate,
its velocity and the controls."""


def effort(joint: Joint, actuators: Sequence[Actuator]) -> Effort:
    """The force of these actuators and of a joint's spring and damper."""
    damping = float(joint.damping[0])
    stiffness = joint.stiffness
    rest = float(joint.rest[0])
    forces = list(map(_force, actuators))
    if joint.force_range is not None:
        forces = [_together(forces, *joint.force_range)]
    if not (forces or stiffness):
        return lambda q, rate, controls: -damping * rate
    if not forces:
        return lambda q, rate, controls: -stiffness * (q - rest) - damping * rate
    if len(forces) == 1 and not (stiffness or damping):
        return forces[0]

    def force(q: float, rate: float, controls: Sequence[float]) -> float:
        total = -stiffness * (q - rest) - damping * rate
        for of_actuator in forces:
            total += of_actuator(q, rate, controls)
        return total

    return force


def _together(forces: Sequence[Effort], low: float, high: float) -> Effort:
    """The sum of forces, within a range."""
    return lambda q, rate, controls: min(
        max(sum(f(q, rate, controls) for f in forces), low), high
    )


def _force(actuator: Actuator) -> Effort:
    """The force of an actuator on its joint."""
    gear = actuator.gear
    gain = actuator.gain
    control = actuator.control
    constant, by_place, by_rate = actuator.bias
    low, high = actuator.force_range or (-math.inf, math.inf)
    least, most = actuator.control_range or (-math.inf, math.inf)
    by_place, by_rate = gear * by_place, gear * by_rate

    def force(q: float, rate: float, controls: Sequence[float]) -> float:
        bent = constant + by_place * q + by_rate * rate
        return gear * min(
            max(gain * min(max(controls[control], least), most) + bent, low), high
        )

    return force
