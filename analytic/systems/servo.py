"""A servo on a hinge: a motor holds a link at its target, in closed form.

With x the angle from the target, the gear n and J = inertia + armature, the motor's own behind the
gear (MuJoCo's documentation, Computation, "Actuation model", of a position actuator),

    J x'' = n F - c x',   F = -n (kp x + kv x'), at most F_max in magnitude                     (1)

is a linear oscillator, overdamped or not, or at the limit a damped body under a constant force.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import Any

from plumbob.analytic.numerics.arithmetic import rounded_inputs
from plumbob.analytic.numerics.rotor.limited_oscillator import LimitedOscillator, Piece
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.parameters import check_fields
from plumbob.analytic.reference import Array, LinearResponse
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.systems.simple_pendulum import SimplePendulum

STATE = "theta", "theta_dot"
ROUNDINGS = 16.0  # of each parameter


@dataclass(frozen=True)
class Servo(LinearResponse):
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
        positives = "inertia", "gear", "kp", "force_limit"
        check_fields(self, positives, ("armature", "kv", "damping"))

    @cached_property
    def started(self) -> SimplePendulum:
        """Eq. 1 without a limit as that of a linear pendulum of J at 1 m."""
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
    def limited(self) -> LimitedOscillator:
        """Eq. 1 behind the gear."""
        square = self.gear**2
        gains = square * self.kp, square * self.kv
        most = self.gear * self.force_limit
        return LimitedOscillator(self.started.mass, *gains, self.damping, most)

    @property
    def system(self) -> SmoothSystem:
        """Eq. 1 as theory steps it."""
        of, matrix, start = self.limited, ((self.started.mass,),), (self.theta, self.theta_dot)

        def torques(p: Any, time: float, q: Any, v: Any) -> tuple[float]:
            return (min(max(of.unlimited(*q, *v), -of.limit), of.limit) - self.damping * v[0],)

        return SmoothSystem(
            STATE[:1], STATE[1:], lambda p, q: matrix, torques, {}, start[:1], start[1:]
        )

    def implicit(self, scheme: Scheme, state: Array) -> tuple[float, float]:
        """Damping [1/s] and stiffness [1/s^2] that a step takes on the state after it: at the limit
        the joint's alone."""
        damping = scheme.implicit_damping * self.started.damping_rate
        if abs(self.limited.unlimited(*state)) >= self.limited.limit:
            return min(damping, self.damping / self.started.mass), 0.0
        return damping, self.started.gravity * scheme.implicit_spring

    def pieces(self) -> Iterator[Piece]:
        """The parts of the motion, one after another."""
        return self.limited.pieces(self.theta, self.theta_dot)

    @cached_property
    def saturates(self) -> bool:
        """Whether the motor reaches its limit."""
        return any(piece.side for piece in islice(self.pieces(), 2))

    @property
    def peak_force(self) -> float:
        """The largest |F| [N m]: that of the start, of the first peak, or the limit."""
        first = Piece(self.limited, 0.0, self.theta, self.theta_dot, 0.0)
        torque = max(abs(first.torque(since)) for since in (0.0, first.peak))
        return min(self.force_limit, torque / self.gear)

    def observe(self, times: Array) -> Mapping[str, Array]:
        """x [rad] and x' [rad/s] at `times` [s], shape (n,)."""
        states = self.limited.states(self.theta, self.theta_dot, times)
        return dict(zip(STATE, states, strict=True))

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """Absolute errors, shape (n,), by the effect of each parameter's rounding."""
        return rounded_inputs(self, lambda servo: servo.observe(times), ROUNDINGS)
