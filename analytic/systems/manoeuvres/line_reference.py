"""The line manoeuvre as a reference: its observables and their uncertainty in double precision."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.reference import Array, LinearResponse
from plumbob.analytic.systems.capsule import NORMAL_FORCES, by_support, normal_force_uncertainty
from plumbob.analytic.systems.manoeuvres import driving_force
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre

# Largest number of roundings between the parameters and an observable.
ARITHMETIC = 8


def condition_number(manoeuvre: LineManoeuvre) -> float:
    """Relative change of the displacement (22) over the largest relative change of M, m, f, g,
    w1, w2 and t1; grows as f g/(mu w1 - f g) when w1 nears its threshold."""
    capsule, closed = manoeuvre.capsule, manoeuvre.closed
    mu, limit = capsule.mass_ratio, capsule.friction * capsule.gravity
    push, pull = mu * manoeuvre.w1, mu * manoeuvre.w2
    by_w1 = push / (push + pull) + push / closed.backward
    by_w2 = pull / (push + pull) - pull / closed.braking
    by_friction = limit / closed.backward + limit / closed.braking
    by_mass = (1.0 - mu) * abs(by_w1 + by_w2)
    return abs(by_w1) + abs(by_w2) + 2 * by_mass + 2 * by_friction + 2.0


@dataclass(frozen=True)
class LineReference(LinearResponse):
    """Exact motion of a line manoeuvre by name of observable, all signed along its direction.

    displacement, velocity: of C [m, m/s]; stroke, stroke_rate: of the slider in the body [m,
    m/s]; heading [rad]; sideways: of C across the line [m]; normal_force_1..3, friction_force
    (resultant on the body) and driving_force (of the actuator on the slider) [N].
    """

    manoeuvre: LineManoeuvre

    def observe(self, times: Array) -> Mapping[str, Array]:
        """Exact observables at `times` >= 0 [s], shape (n,) (Chernousko 2020, eqs. 7-22)."""
        line, times = self.manoeuvre, np.asarray(times, dtype=np.float64)
        return {
            "displacement": line.body_displacement(times),
            "velocity": line.body_velocity(times),
            "stroke": line.strokes(times),
            "stroke_rate": line.relative_velocity(times),
            "heading": np.zeros_like(times),
            "sideways": np.zeros_like(times),
            **by_support(line.normal_forces(times)),
            "friction_force": line.friction_force(times),
            "driving_force": line.driving_force(times),
        }

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """Absolute error [SI] at `times` [s], shape (n,), that parameters and times rounded to
        double, and the arithmetic, may have caused: first order, term by term, in magnitude."""
        line, times = self.manoeuvre, np.asarray(times, dtype=np.float64)
        capsule, spent, zero = line.capsule, _Spent.of(line, times), np.zeros_like(times)
        displacement, velocity = _body_roundings(line, spent, times)
        stroke, stroke_rate = _slider_roundings(line, spent, times)
        slack = normal_force_uncertainty(capsule, abs(line.start) + line.stroke)
        return {
            "displacement": ROUNDOFF * displacement,
            "velocity": ROUNDOFF * velocity,
            "stroke": ROUNDOFF * stroke,
            "stroke_rate": ROUNDOFF * stroke_rate,
            "heading": zero,
            "sideways": zero,
            **dict.fromkeys(NORMAL_FORCES, zero + slack),
            "friction_force": zero + ARITHMETIC * ROUNDOFF * capsule.friction * capsule.weight,
            "driving_force": driving_force.uncertainty(
                capsule, line.friction_force(times), line.relative_acceleration(times)
            ),
        }


@dataclass(frozen=True)
class _Accelerations:
    """Magnitudes [m/s^2] that add up to the body's acceleration: mu w1, mu w2 and f g."""

    push: float
    pull: float
    friction: float

    @classmethod
    def of(cls, line: LineManoeuvre) -> _Accelerations:
        mu, friction = line.capsule.mass_ratio, line.capsule.friction * line.capsule.gravity
        return cls(mu * line.w1, mu * line.w2, friction)

    def integrated(self, pushed: Array, braked: Array) -> Array:
        """Integral in magnitude, each term as often as it has rounded parameters: mu w has three
        (m, M, w), f g two. The weights are of the push and of the brake, shape (n,)."""
        driven = 3 * (self.push * pushed + self.pull * braked)
        return driven + 2 * self.friction * (pushed + braked)


@dataclass(frozen=True)
class _Spent:
    """Time [s] spent at `times`, shape (n,): pushed, braked while the body slides (`late`) or the
    slider moves (`long`), t1 once past (`after`); and the weights [s^2] of the accelerations in the
    displacement. A shift of t1 or of the time changes an integral by the jump there, or by the
    rate."""

    pushed: Array
    late: Array
    long: Array
    after: Array

    @classmethod
    def of(cls, line: LineManoeuvre, times: Array) -> _Spent:
        t1 = line.t1
        return cls(
            np.minimum(times, t1),
            np.clip(times - t1, 0.0, line.closed.braking_time),
            np.clip(times - t1, 0.0, line.t2 - t1),
            np.where(times < t1, 0.0, t1),
        )

    @property
    def way_pushed(self) -> Array:
        return 0.5 * self.pushed**2 + self.pushed * self.late

    @property
    def way_braked(self) -> Array:
        return 0.5 * self.late**2


def _body_roundings(line: LineManoeuvre, spent: _Spent, times: Array) -> tuple[Array, Array]:
    """Errors of displacement and velocity of C in units of the round-off."""
    body, few = _Accelerations.of(line), 1 + ARITHMETIC
    displacement = few * body.integrated(spent.way_pushed, spent.way_braked)
    speed = np.abs(line.body_velocity(times))
    displacement += spent.after * (body.push + body.pull) * spent.late + times * speed
    velocity = few * body.integrated(spent.pushed, spent.late)
    velocity += spent.after * (body.push + body.pull)
    velocity += times * (body.push + body.pull + body.friction)
    return displacement, velocity


def _slider_roundings(line: LineManoeuvre, spent: _Spent, times: Array) -> tuple[Array, Array]:
    """Errors of stroke and stroke rate in units of the round-off."""
    few, both = 1 + ARITHMETIC, line.w1 + line.w2
    slid = line.w1 * (0.5 * spent.pushed**2 + spent.pushed * spent.long)
    slid += 0.5 * line.w2 * spent.long**2
    rate = np.abs(line.relative_velocity(times))
    stroke = few * slid + spent.after * both * spent.long + times * rate
    slid_rate = line.w1 * spent.pushed + line.w2 * spent.long
    return stroke, few * slid_rate + spent.after * both + times * both
