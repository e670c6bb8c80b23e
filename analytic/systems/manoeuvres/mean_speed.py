"""The mean speed of repeated line manoeuvres, and the fastest manoeuvre in closed form."""

from __future__ import annotations

import math

from plumbob.analytic.parameters import positive
from plumbob.analytic.systems.capsule import Capsule, longest_stroke
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.manoeuvres.slow_motion import proper_fraction

# Let a = f g, x = f g/(mu w1) < 1, y = f g/(mu w2) >= 1, L the stroke, and p the fraction of f g/mu
# in the return. By eqs. 17, 18, 21 and 22 (Chernousko 2020) the displacement, the time of the
# manoeuvre and the time of the return are
#     |dx| = mu L (1 - x)/(1 + y),     t2 = sqrt(2 mu L (x + y)/a),     2 sqrt(mu L/(p a)),
# and the mean speed is
#     V = sqrt(mu a L) (1 - x)/(1 + y) / (sqrt(2 (x + y)) + 2/sqrt(p)).
# V falls with x and with y, and grows with p and L. So it is largest at y = p = 1 and x -> 0.


def mean_speed(
    capsule: Capsule, w1: float, w2: float, stroke: float, fraction: float = 1.0
) -> float:
    """Returns the magnitude of the mean speed [m/s] of repeated manoeuvres of `stroke` [m] with
    accelerations `w1`, `w2` [m/s^2]. Each is followed at once by a slow return at `fraction` of f
    g/mu. Raises ParameterError."""
    positive("friction", capsule.friction)
    positive("stroke", stroke)
    positive("w1", w1)
    positive("w2", w2)
    proper_fraction("fraction", fraction)
    x = capsule.holding_acceleration / w1
    y = capsule.holding_acceleration / w2
    displacement = (1.0 - x) / (1.0 + y)
    duration = math.sqrt(2.0 * (x + y)) + 2.0 / math.sqrt(fraction)
    return _speed_unit(capsule, stroke) * displacement / duration


def fastest_speed(capsule: Capsule, stroke: float) -> float:
    """Returns the mean speed [m/s] that no manoeuvre of `stroke` [m] with a slow return exceeds:
    sqrt(mu f g stroke)/(2 sqrt(2) + 4). It is reached with w2 = f g/mu, a return at f g/mu, and w1
    -> infinity. Raises ParameterError."""
    positive("friction", capsule.friction)
    positive("stroke", stroke)
    return _speed_unit(capsule, stroke) / (2.0 * math.sqrt(2.0) + 4.0)


def fastest_manoeuvre(capsule: Capsule, w1: float, stroke: float) -> LineManoeuvre:
    """Returns the fastest manoeuvre of `stroke` [m] with the acceleration `w1` [m/s^2], along the
    body's x axis and in the middle of the longest stroke. Raises ParameterError."""
    w2 = capsule.holding_acceleration
    t1 = math.sqrt(2.0 * w2 * positive("stroke", stroke) / (positive("w1", w1) * (w1 + w2)))
    low, high = longest_stroke(capsule, 0.0)
    return LineManoeuvre(capsule, w1, w2, t1, start=0.5 * (low + high - stroke))


def _speed_unit(capsule: Capsule, stroke: float) -> float:
    """Returns sqrt(mu f g stroke) [m/s], the unit of the mean speeds."""
    return math.sqrt(capsule.mass_ratio * capsule.friction * capsule.gravity * stroke)
