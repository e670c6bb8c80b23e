"""A servo on a hinge: a motor holds a link at its target, in closed form.

Let x be the angle from the target, n the gear ratio, and J = inertia + armature, the armature
behind the gear (MuJoCo's documentation, Computation, "Actuation model", of a position actuator):

    J x'' = n F - c x',   F = -n (kp x + kv x'), at most F_max in magnitude                     (1)

Below the limit this is a linear oscillator, overdamped or not. At the limit it is a damped body
under a constant force. Below the limit F obeys the same equation as x, so each of its peaks is
lower than the one before. At the limit the unlimited F has at most one turning point. F is
continuous from piece to piece, so an error of a switching time changes the motion in second order
only.

If the motor's controller is digital, it computes F from x and x' at samples, and F is held between
them: `analytic/systems/held_loop.py` has that motion. Such a motor has no limit here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import islice
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import rounded_inputs
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.linear_oscillator import linear_motion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.parameters import ParameterError, check_fields
from plumbob.analytic.reference import Array, LinearResponse, Signals
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.systems.held_loop import HeldLoop
from plumbob.analytic.systems.simple_pendulum import SimplePendulum

SERVO_OBSERVABLES = ("theta", "theta_dot")
# roundings of each parameter in the uncertainty: 100 random servos need 1/40 of it in the median
SERVO_ROUNDINGS = 12.0


@dataclass(frozen=True)
class Servo(LinearResponse):
    """A link's `inertia` and a motor's `armature` [kg m^2], the `gear` ratio, the gains `kp` [N
    m/rad] and `kv` [N m s/rad], the `force_limit` [N m] before the gear, and the joint's `damping`
    [N m s/rad]. `theta` [rad] from the target and its rate are at time 0. A digital controller
    samples every `hold` [s], and its force acts `delay` [s] later; without a hold the motor is
    continuous. Raises ParameterError.

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
    hold: float = 0.0
    delay: float = 0.0

    def __post_init__(self) -> None:
        positives = "inertia", "gear", "kp", "force_limit"
        check_fields(self, positives, ("armature", "kv", "damping", "hold", "delay"))
        if self.delay and not self.hold:
            raise ParameterError("delay", self.delay, "0 without a hold")
        # A loop checks its own numbers.
        assert not self.hold or self.loop

    @cached_property
    def loop(self) -> HeldLoop | None:
        """The loop of a digital controller; None if the motor is continuous."""
        if not self.hold:
            return None
        gear_squared = self.gear**2
        return HeldLoop(
            inertia=self.inertia + self.armature,
            damping=self.damping,
            stiffness=gear_squared * self.kp,
            rate_gain=gear_squared * self.kv,
            hold=self.hold,
            delay=self.delay,
            theta=self.theta,
            theta_dot=self.theta_dot,
        )

    @cached_property
    def started(self) -> SimplePendulum:
        """Eq. 1 without a limit, as a linear pendulum with the mass J at 1 m."""
        total = self.inertia + self.armature
        square = self.gear**2
        return SimplePendulum(
            length=1.0,
            gravity=square * self.kp / total,
            damping_rate=(square * self.kv + self.damping) / total,
            forcing_amplitude=0.0,
            forcing_frequency=0.0,
            theta=self.theta,
            theta_dot=self.theta_dot,
            linear=True,
            mass=total,
        )

    @property
    def joint_part(self) -> float:
        """The joint's damping over the total damping that acts within a step; 1 if the motor has
        none."""
        motor = 0.0 if self.hold else self.gear**2 * self.kv
        return self.damping / (self.damping + motor) if motor else 1.0

    @property
    def limit(self) -> float:
        """The largest torque after the gear [N m]."""
        return self.gear * self.force_limit

    def unlimited(self, x: float, v: float) -> float:
        """Returns the torque n F without its limit [N m] at the angle x [rad] and the rate v
        [rad/s]."""
        return -(self.gear**2) * (self.kp * x + self.kv * v)

    @property
    def system(self) -> SmoothSystem:
        """Eq. 1 as a smooth system, for the theory of time stepping."""
        matrix = ((self.started.mass,),)

        def torques(p: Any, time: float, q: Any, v: Any) -> tuple[float]:
            """Returns the torque of motor and damping [N m]."""
            torque = min(max(self.unlimited(*q, *v), -self.limit), self.limit)
            return (torque - self.damping * v[0],)

        return SmoothSystem(
            coordinates=SERVO_OBSERVABLES[:1],
            rates=SERVO_OBSERVABLES[1:],
            mass_matrix=lambda p, q: matrix,
            forces=torques,
            parameters={},
            position=(self.theta,),
            rate=(self.theta_dot,),
        )

    def implicit(self, scheme: Scheme, state: Sequence[Any]) -> tuple[float, float]:
        """Returns the damping [1/s] and the stiffness [1/s^2] that a step of `scheme` from `state`
        treats implicitly. At the force limit only the joint's damping is left."""
        damping = scheme.implicit_damping * self.started.damping_rate
        if abs(self.unlimited(*state)) >= self.limit:
            return min(damping, self.damping / self.started.mass), 0.0
        return damping, self.started.gravity * scheme.implicit_spring

    def pieces(self) -> Iterator[ServoPiece]:
        """Yields the pieces of the motion in order."""
        torque = self.unlimited(self.theta, self.theta_dot)
        side = math.copysign(1.0, torque) if abs(torque) > self.limit else 0.0
        piece: ServoPiece | None = ServoPiece(self, 0.0, self.theta, self.theta_dot, side)
        while piece is not None:
            yield piece
            piece = piece.following

    @cached_property
    def saturates(self) -> bool:
        """True if the motor reaches its limit, which it has only if it is continuous."""
        return not self.hold and any(piece.side for piece in islice(self.pieces(), 2))

    @property
    def peak_force(self) -> float:
        """The largest |F| [N m]: at the start, at the first peak, or at the limit."""
        first = ServoPiece(self, 0.0, self.theta, self.theta_dot, 0.0)
        torque = max(abs(first.torque(since)) for since in (0.0, first.peak))
        return min(self.force_limit, torque / self.gear)

    def observe(self, times: Array) -> Signals:
        """Exact x [rad] and x' [rad/s] at `times` [s], shape (n,)."""
        states = np.zeros((2, len(times)))
        for piece in self.pieces():
            later = times >= piece.begin
            if not later.any():
                break
            states[:, later] = piece.states(times[later] - piece.begin)
        return dict(zip(SERVO_OBSERVABLES, states, strict=True))

    def uncertainty(self, times: Array) -> Signals:
        """Bound on the error of each observable, shape (n,), by the rounding of each parameter."""
        return rounded_inputs(self, lambda servo: servo.observe(times), SERVO_ROUNDINGS)


@dataclass(frozen=True)
class ServoPiece:
    """A piece of the motion from the time `begin` [s], with the angle `x` and the rate `v` at that
    time. `side` is 1 or -1 if n F is at its limit on that side, else 0."""

    servo: Servo
    begin: float
    x: float
    v: float
    side: float

    @cached_property
    def motion(self) -> DrivenRotor:
        """The equation of motion of a piece, divided by J. In a piece the servo's force is constant
        at its limit, with the sign `side`; or it is not limited, if `side` is 0."""
        servo = self.servo
        inertia = servo.started.mass
        if not self.side:
            return servo.started.rotor
        return DrivenRotor(
            damping_rate=servo.damping / inertia,
            forcing_amplitude=self.side * servo.limit / inertia,
            forcing_phase=math.pi / 2.0,  # a constant torque: the sine of a frequency of 0
        )

    def states(self, since: Array | float) -> tuple[Array, Array]:
        """Returns the coordinate x and its rate x' at the times `since` the begin [s], shape
        (n,)."""
        return linear_motion(self.motion, self.x, self.v, np.asarray(since))

    def torque(self, since: float) -> float:
        """Returns the torque n F without its limit [N m] at the time `since` its begin [s]."""
        return self.servo.unlimited(*map(float, self.states(since)))

    def slope(self, since: float) -> float:
        """Returns the time derivative of that torque [N m/s] at the time `since` its begin [s]."""
        x, v = map(float, self.states(since))
        return self.servo.unlimited(v, float(self.motion.acceleration(0.0, x, v)))

    @cached_property
    def peak(self) -> float:
        """The time from its begin to the first peak of |n F| below the limit [s]; 0 if |n
        F| falls."""
        stiffness = self.motion.stiffness
        damping = self.motion.damping_rate
        torque = self.torque(0.0)
        slope = self.slope(0.0)
        # The slope of the torque is e^(-damping t/2) (slope c + bend s), with c = cos(root t) and
        # s = sin(root t)/root. If the motion is overdamped, c and s are hyperbolic functions.
        bend = -stiffness * torque - damping / 2 * slope
        root = math.sqrt(abs(stiffness - damping**2 / 4))
        time = 0.0
        if stiffness > damping**2 / 4:
            time = math.atan2(-root * slope, bend) % math.pi / root
        elif root * abs(slope) < abs(bend):
            time = math.atanh(-root * slope / bend) / root if root else -slope / bend
        return max(time, 0.0)

    @property
    def following(self) -> ServoPiece | None:
        """The next piece; None after the last one."""
        end = self._time_of_leaving_limit() if self.side else self._time_of_reaching_limit()
        if end is None:
            return None
        x, v = map(float, self.states(end))
        side = 0.0 if self.side else math.copysign(1.0, self.torque(self.peak))
        return replace(self, begin=self.begin + end, x=x, v=v, side=side)

    def _time_of_reaching_limit(self) -> float | None:
        """Returns the time since the begin [s] at which |n F| reaches the limit; None if never."""
        side = math.copysign(1.0, self.torque(self.peak))
        excess = partial(self._excess, side)
        if not self.peak or excess(self.peak) <= 0.0:
            return None
        return _root(excess, 0.0, self.peak) if excess(0.0) < 0.0 else 0.0

    def _time_of_leaving_limit(self) -> float:
        """Returns the time since the begin [s] at which the unlimited |n F| falls to the limit."""
        excess = partial(self._excess, self.side)
        first = 0.0
        last = 1.0 / math.sqrt(self.servo.started.gravity)
        while excess(last) > 0.0:
            last *= 2.0
        if self.side * self.slope(0.0) > 0.0:
            first = _root(self.slope, 0.0, last)
        return _root(excess, first, last)

    def _excess(self, side: float, since: float) -> float:
        """Returns how far the torque n F on this `side` exceeds its limit [N m]."""
        return side * self.torque(since) - self.servo.limit


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Returns the zero of a function between `low` and `high`. Raises ArithmeticError if rounding
    leaves no change of sign."""
    from scipy.optimize import brentq

    if not function(low) * function(high) <= 0.0:
        raise ArithmeticError("no change of sign")
    return float(brentq(function, low, high))
