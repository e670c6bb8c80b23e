"""The line manoeuvre as a reference: its observables, and what double precision allows them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import normal_force_uncertainty
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre

# Roundings on the longest way from the parameters to an observable, beside those of the parameters.
ARITHMETIC = 8


def condition_number(manoeuvre: LineManoeuvre) -> float:
    """Relative change of the displacement (22) over the largest relative change of M, m, f, g,
    w1, w2 and t1; grows as f g/(mu w1 - f g) when w1 nears its threshold."""
    capsule, closed = manoeuvre.capsule, manoeuvre.closed
    mu, grip = capsule.mass_ratio, capsule.friction * capsule.gravity
    push, pull = mu * manoeuvre.w1, mu * manoeuvre.w2
    by_w1 = push / (push + pull) + push / closed.backward
    by_w2 = pull / (push + pull) - pull / closed.braking
    by_grip = grip / closed.backward + grip / closed.braking
    by_mass = (1.0 - mu) * abs(by_w1 + by_w2)
    return abs(by_w1) + abs(by_w2) + 2 * by_mass + 2 * by_grip + 2.0


@dataclass(frozen=True)
class LineReference:
    """Exact motion of a line manoeuvre by name of observable, all signed along its direction.

    displacement, velocity: of C [m, m/s]; stroke, stroke_rate: of the slider in the body [m,
    m/s]; heading [rad]; sideways: of C across the line [m]; normal_force_1..3 and
    friction_force (resultant on the body) [N].
    """

    manoeuvre: LineManoeuvre

    def observe(self, times: Array) -> Mapping[str, Array]:
        """Exact observables at `times` >= 0 [s], shape (n,) (Chernousko 2020, eqs. 7-22)."""
        line, times = self.manoeuvre, np.asarray(times, dtype=np.float64)
        forces = line.normal_forces(times)
        return {
            "displacement": line.body_displacement(times),
            "velocity": line.body_velocity(times),
            "stroke": line.strokes(times),
            "stroke_rate": line.relative_velocity(times),
            "heading": np.zeros_like(times),
            "sideways": np.zeros_like(times),
            **{f"normal_force_{i + 1}": forces[:, i] for i in range(3)},
            "friction_force": line.friction_force(times),
        }

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """Absolute error [SI] at `times` [s], shape (n,), that parameters and times rounded to
        double, and the arithmetic, may have caused: first order, term by term, in magnitude."""
        line, times = self.manoeuvre, np.asarray(times, dtype=np.float64)
        capsule, w1, w2, t1 = line.capsule, line.w1, line.w2, line.t1
        mu, grip = capsule.mass_ratio, capsule.friction * capsule.gravity
        push, pull = mu * w1, mu * w2
        pushed = np.minimum(times, t1)
        late = np.clip(times - t1, 0.0, line.closed.braking_time)
        long = np.clip(times - t1, 0.0, line.t2 - t1)
        after = np.where(times < t1, 0.0, t1)
        # mu w carries three rounded parameters (m, M, w), f g two; a shift of t1 or of the time
        # changes what is integrated by the jump there, or by the rate.
        gone = 0.5 * pushed**2 + pushed * late
        turned = 0.5 * late**2
        speed, rate = np.abs(line.body_velocity(times)), np.abs(line.relative_velocity(times))
        displacement = 3 * (push * gone + pull * turned) + 2 * grip * (gone + turned)
        velocity = 3 * (push * pushed + pull * late) + 2 * grip * (pushed + late)
        slid = w1 * (0.5 * pushed**2 + pushed * long) + 0.5 * w2 * long**2
        slid_rate = w1 * pushed + w2 * long
        stroke = (1 + ARITHMETIC) * slid + after * (w1 + w2) * long + times * rate
        slack = normal_force_uncertainty(capsule, abs(line.start) + line.stroke)
        zero = np.zeros_like(times)
        return {
            "displacement": ROUNDOFF
            * ((1 + ARITHMETIC) * displacement + after * (push + pull) * late + times * speed),
            "velocity": ROUNDOFF
            * ((1 + ARITHMETIC) * velocity + after * (push + pull) + times * (push + pull + grip)),
            "stroke": ROUNDOFF * stroke,
            "stroke_rate": ROUNDOFF
            * ((1 + ARITHMETIC) * slid_rate + after * (w1 + w2) + times * (w1 + w2)),
            "heading": zero,
            "sideways": zero,
            **{f"normal_force_{i + 1}": zero + slack for i in range(3)},
            "friction_force": zero + ARITHMETIC * ROUNDOFF * capsule.friction * capsule.weight,
        }

    def nonlinearity(self, times: Array, errors: Mapping[str, Array]) -> float:
        """0: the error of a step does not depend on how far off the motion is."""
        return 0.0
