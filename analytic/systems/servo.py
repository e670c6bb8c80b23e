"""A servo on a hinge: a motor holds a link at its target, in closed form.

With x the angle from the target, the gear n and J = inertia + armature, the motor's own behind the
gear (MuJoCo's documentation, Computation, "Actuation model", of a position actuator),

    J x'' = n F - c x',   F = -n (kp x + kv x')                                                 (1)

is a linear oscillator, overdamped or not, as long as |F| is below its limit. F itself obeys the
equation of x, so that its peaks fall from one to the next: the largest |F| is that of the start or
of the first peak.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from plumbob.analytic.numerics.rotor.linear_oscillator import LinearOscillator
from plumbob.analytic.parameters import ParameterError, finite, non_negative, positive
from plumbob.analytic.systems.simple_pendulum import SimplePendulum


@dataclass(frozen=True)
class Servo:
    """A link's `inertia` and a motor's `armature` [kg m^2], its `gear`, its gains `kp` [N m/rad]
    and `kv` [N m s/rad] and its `force_limit` [N m] before the gear, a joint's `damping`
    [N m s/rad]; `theta` [rad] from the target and its rate at time 0; raises ParameterError.

    >>> Servo(0.5, 0.1, 10.0, 2.0, 0.1, 0.0, 9.0, -0.4, 0.0).started.damping_rate
    16.666666666666668
    """

    inertia: float
    armature: float
    gear: float
    kp: float
    kv: float
    damping: float
    force_limit: float
    theta: float
    theta_dot: float

    def __post_init__(self) -> None:
        for field in fields(self):
            check = {"theta": finite, "theta_dot": finite}.get(field.name, positive)
            if field.name in ("armature", "kv", "damping"):
                check = non_negative
            check(field.name, getattr(self, field.name))
        if not self.peak_force <= self.force_limit:
            least = (
                f"at least {self.peak_force:.6g} N m, which the motion takes: at its limit a motor"
            )
            raise ParameterError("force_limit", self.force_limit, f"{least} is no linear servo")

    @cached_property
    def started(self) -> SimplePendulum:
        """Eq. 1 as that of a linear pendulum of J at 1 m."""
        total, square = self.inertia + self.armature, self.gear**2
        stiffness, damping = square * self.kp / total, (square * self.kv + self.damping) / total
        start = self.theta, self.theta_dot
        return SimplePendulum(1.0, stiffness, damping, 0.0, 0.0, *start, linear=True, mass=total)

    @property
    def joint_part(self) -> float:
        """The part of all damping that is the joint's, 1 where there is none."""
        inside = self.gear**2 * self.kv
        return self.damping / (self.damping + inside) if inside else 1.0

    @cached_property
    def peak_force(self) -> float:
        """The largest |F| of eq. 1 [N m]."""
        pull, damping = self.started.gravity, self.started.damping_rate
        speed = -pull * self.theta - damping * self.theta_dot
        force, slope = (
            -self.gear * (self.kp * x + self.kv * v)
            for x, v in ((self.theta, self.theta_dot), (self.theta_dot, speed))
        )
        bend = (
            -pull * force - damping / 2 * slope
        )  # F' falls as e^(-damping t/2) (slope c + bend s)
        root, late = math.sqrt(abs(pull - damping**2 / 4)), 0.0  # with c and s/root cosine and sine
        if pull > damping**2 / 4:
            late = math.atan2(-root * slope, bend) % math.pi / root
        elif root * abs(slope) < abs(bend):
            late = math.atanh(-root * slope / bend) / root if root else -slope / bend
        later = LinearOscillator(pull, damping).motion(force, slope, np.array(max(late, 0.0)))
        return max(abs(force), abs(float(later[0])))
