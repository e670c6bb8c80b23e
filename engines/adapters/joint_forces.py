"""The force of all actuators of a joint, as a step begins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from plumbob.engines.mechanism import Actuator, Joint, Mechanism


@dataclass(frozen=True)
class JointForces:
    """The actuators of a joint with one degree of freedom, and the bounds of their sum."""

    actuators: tuple[Actuator, ...]
    force_range: tuple[float, float] | None  # [N m] or [N]

    @property
    def alone(self) -> bool:
        """Whether a force may act where all controls are 0."""
        return any(any(actuator.bias) for actuator in self.actuators)

    def total(self, controls: Sequence[float], place: float, rate: float) -> float:
        """The force [N m] or [N] under controls, none of which stands for 0, at a coordinate [rad]
        or [m] and its rate."""
        total = 0.0
        for motor in self.actuators:
            control = _within(controls[motor.control] if controls else 0.0, motor.control_range)
            force = motor.gain * control + motor.bias[0]
            force += motor.gear * (motor.bias[1] * place + motor.bias[2] * rate)
            total += motor.gear * _within(force, motor.force_range)
        return _within(total, self.force_range)


def joint_forces(mechanism: Mechanism, joint: Joint) -> JointForces:
    """The actuators of a joint of a mechanism."""
    own = (a for a in mechanism.actuators if mechanism.joints[a.joint] is joint)
    return JointForces(tuple(own), joint.force_range)


def _within(value: float, limits: tuple[float, float] | None) -> float:
    return value if limits is None else min(max(value, limits[0]), limits[1])
