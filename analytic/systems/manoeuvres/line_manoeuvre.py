"""The line manoeuvre: the slider accelerates once and brakes once, and the body moves (Chernousko
2020).

    mu       m/(M + m), `Capsule.mass_ratio`
    f g/mu   largest acceleration of the slider that friction holds, `holding_acceleration`
    w1, w2   accelerations of the slider in the body, forward and then backward
    t1, t2   times at which the slider's acceleration switches, and at which the slider stops
    t_star   time at which the body stops
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import ClassVar

import numpy as np

from plumbob.analytic.parameters import ParameterError, check_fields
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule, check_loads
from plumbob.analytic.systems.capsule_motion import MotionKind, SingleMotion
from plumbob.analytic.systems.manoeuvres.line_motion import LineMotion, Phase

# Relative rounding of f g/mu from doubles. w2 may equal f g/mu, w1 may not.
THRESHOLD_ROUNDING = 4 * Fraction(2) ** -52


@dataclass(frozen=True)
class ClosedForm:
    """The manoeuvre's numbers. Each is the exact value for the given doubles, rounded once."""

    backward: float  # mu w1 - f g, the body's backward acceleration on (0, t1) [m/s^2]
    braking: float  # mu w2 + f g, the body's deceleration on (t1, t_star) [m/s^2]
    braking_time: float  # t_star - t1 [s]
    t_star: float  # [s], eq. 20
    t2: float  # [s], eq. 17
    stroke: float  # [m], eq. 18
    displacement: float  # [m], eq. 22


def closed_form(capsule: Capsule, w1: float, w2: float, t1: float) -> ClosedForm:
    """Returns eqs. 17, 18, 20 and 22 (Chernousko 2020), evaluated in rational arithmetic.

    w1, w2 [m/s^2], t1 [s]. Every number is a quotient of polynomials in the parameters. In double
    precision the difference mu w1 - f g would lose all its digits as w1 -> f g/mu. The source
    prints eq. 18 with an angular velocity, omega_2, in place of w2, which follows from its eq. 17.
    Raises ParameterError naming the parameter that violates 0 < w2 <= f g/mu < w1 (eq. 15).
    """
    body = Fraction(capsule.body_mass)
    slider = Fraction(capsule.slider_mass)
    push = Fraction(w1)
    pull = Fraction(w2)
    time = Fraction(t1)
    mu = slider / (body + slider)
    limit = Fraction(capsule.friction) * Fraction(capsule.gravity)
    if not mu * push > limit * (1 + THRESHOLD_ROUNDING):
        raise ParameterError("w1", w1, f"greater than f g/mu = {float(limit / mu)!r} m/s^2")
    # Without friction t_star = t2: the body does not have to stick, so w2 has no bound.
    if limit > 0 and mu * pull > limit * (1 + THRESHOLD_ROUNDING):
        raise ParameterError("w2", w2, f"at most f g/mu = {float(limit / mu)!r} m/s^2")
    backward = mu * push - limit
    braking = mu * pull + limit
    t_star = mu * (push + pull) * time / braking
    try:
        closed = ClosedForm(
            backward=float(backward),
            braking=float(braking),
            braking_time=float(backward * time / braking),
            t_star=float(t_star),
            t2=float((push + pull) * time / pull),
            stroke=float(push * (push + pull) * time**2 / (2 * pull)),
            displacement=float(-backward * time * t_star / 2),
        )
    except OverflowError:
        raise ParameterError(
            "w1, w2, t1", (w1, w2, t1), "such that the motion is finite"
        ) from None
    if closed.displacement == 0.0:
        raise ParameterError("displacement", 0.0, "other than 0")
    return closed


@dataclass(frozen=True)
class LineManoeuvre(SingleMotion, LineMotion):
    """Body and slider move from rest to rest along one line through C (Chernousko 2020, eqs.
    11-22).

    The slider's acceleration relative to the body is w1 until t1, then -w2 until t2 [m/s^2, s],
    along `direction` [rad, from the body's x axis]. The slider starts at `start` [m] on that line,
    signed from C. Raises ParameterError for parameters outside eq. 15, and if a normal force is not
    positive along the whole path.

    >>> corners = ((0.2, 0.0), (-0.1, 0.15), (-0.1, -0.15))
    >>> capsule = Capsule(1.0, 0.3, 0.02, corners, friction=0.3, gravity=9.81)
    >>> line = LineManoeuvre(capsule, w1=40.0, w2=10.0, t1=0.05)
    >>> print(f"{1e3 * line.displacement:.3f} mm in {line.t_star:.4f} s")
    -17.272 mm in 0.1099 s
    """

    capsule: Capsule
    w1: float
    w2: float
    t1: float
    direction: float = 0.0
    start: float = 0.0
    kind: ClassVar[MotionKind] = "line"

    def __post_init__(self) -> None:
        check_fields(self, ("w1", "w2", "t1"), others=("capsule",))
        _ = self.closed  # raises ParameterError for accelerations outside eq. 15
        check_loads(self.capsule, self.ends)

    @cached_property
    def closed(self) -> ClosedForm:
        """The numbers of eqs. 17, 18, 20 and 22, free of cancellation."""
        return closed_form(self.capsule, self.w1, self.w2, self.t1)

    @property
    def t2(self) -> float:
        """Time at which the slider comes to rest in the body [s] (eq. 17)."""
        return self.closed.t2

    @property
    def t_star(self) -> float:
        """Time at which the body comes to rest [s] (eq. 20); t1 < t_star <= t2."""
        return self.closed.t_star

    @property
    def stroke(self) -> float:
        """The slider's total displacement relative to the body [m] (eq. 18, with w2 for
        omega_2)."""
        return self.closed.stroke

    @property
    def displacement(self) -> float:
        """The body's total displacement along `direction` [m]; it is negative (eq. 22)."""
        return self.closed.displacement

    @property
    def sliding_time(self) -> float:
        """Time during which the body slides [s]."""
        return self.t_star

    @cached_property
    def phases(self) -> tuple[Phase, ...]:
        """Four phases: the slider accelerates; it brakes while the body slides; it brakes while the
        body rests; both rest."""
        closed = self.closed
        push = Phase(0.0, 0.0, 0.0, self.w1, acceleration=-closed.backward, slides=True)
        brake = push.after(self.t1)._replace(pull=-self.w2, acceleration=closed.braking)
        end = Phase(self.t2, self.stroke, 0.0, 0.0, self.displacement)
        stop = brake.after(closed.braking_time)
        body_at_rest = end._replace(
            start=self.t_star, stroke=stop.stroke, stroke_rate=stop.stroke_rate, pull=stop.pull
        )
        return push, brake, body_at_rest, end


def printed_body_velocity(manoeuvre: LineManoeuvre, times: Array) -> Array:
    """Returns the velocity of C [m/s] at `times` [s], shape (n,), by eq. 19 as printed (Chernousko
    2020).

    The first term of its second line has t in place of the t1 that follows from eq. 11: a misprint.
    As printed, the body does not stop at t_star (eq. 20, Fig. 2), and if w1 is large enough it
    never stops.
    """
    closed = manoeuvre.closed
    late = np.maximum(times - manoeuvre.t1, 0.0)
    return -closed.backward * times + closed.braking * late


def condition_number(manoeuvre: LineManoeuvre) -> float:
    """Returns the ratio of the displacement's relative change (eq. 22) to the largest relative
    change of M, m, f, g, w1, w2 and t1. It grows as f g/(mu w1 - f g) when w1 approaches its lower
    bound."""
    capsule = manoeuvre.capsule
    closed = manoeuvre.closed
    mu = capsule.mass_ratio
    limit = capsule.friction * capsule.gravity
    push = mu * manoeuvre.w1
    pull = mu * manoeuvre.w2
    by_w1 = push / (push + pull) + push / closed.backward
    by_w2 = pull / (push + pull) - pull / closed.braking
    by_friction = limit / closed.backward + limit / closed.braking
    by_mass = (1.0 - mu) * abs(by_w1 + by_w2)
    return abs(by_w1) + abs(by_w2) + 2 * by_mass + 2 * by_friction + 2.0
