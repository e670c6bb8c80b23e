"""How uniform a pendulum's rotation is, by three measures, and which of them a platform can
improve.

Sudakov 2015 concludes that in some regime a turning platform makes rotation more uniform. Whether
it does depends on the measure. With a start at theta = 0 with the same theta_dot_0 > 0:

    spread      (max theta_dot - min theta_dot) / theta_dot_0
    deviation   standard deviation of theta_dot over its mean, both in time, over a turn
    near        part of the turn's time in which theta_dot is within 5 % of theta_dot_0

The spread never shrinks. V(0) = -c and V(pi) = c for every platform rate, pivot_y and inertia_yz,
because their terms vanish with sin(theta). So theta_dot is theta_dot_0 at 0 and (theta_dot_0^2 - 4
c/I)^(1/2) at pi, for every platform. On a platform at rest V = -c cos(theta) has its extremes
there, and the spread is the difference of just these two speeds. On a turning platform both speeds
still occur, so the spread is at least that difference. It is larger if V leaves [-c, c]: always if
b != 0, since V'(0) = -b; if b = 0, only for 2 |a| > c, beyond the pitchfork.

The other two measures can improve: a > 0 lowers V on the flanks, so the slow passage near pi is
shorter. Far above the barrier they do not both improve: there the deviation tends to (a^2/8 + b^2/2
+ c^2/2)^(1/2) / (I theta_dot_0^2), which any rotation of the platform increases.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.quad import double
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion

# largest relative difference from the initial speed that counts as near
NEAR_INITIAL_SPEED = 0.05
ANGLES_OF_TURN = 2048  # angles of a turn: the trapezoid rule converges geometrically
TIMES_OF_PERIOD = 20_000  # times of a period: they give parts of it to four digits


@dataclass(frozen=True)
class Uniformity:
    """The three measures of the module's docstring and the period, of one rotation or of many,
    shape (...). NaN for motions that do not turn over."""

    spread: Array
    deviation: Array
    near: Array
    period: Array  # time of a turn [s]


def uniformity_of_motion(motion: PendulumMotion) -> Uniformity:
    """Returns the measures of an exact rotation that starts at its `theta`, by sampling: the means
    converge geometrically."""
    times = (np.arange(TIMES_OF_PERIOD) + 0.5) * motion.period / TIMES_OF_PERIOD
    return _measures(
        motion.state(times)[1], np.asarray(motion.theta_dot), np.ones(TIMES_OF_PERIOD)
    )


def uniformity_from_bottom(
    potential: TrigonometricPotential, inertia: Array | float, speeds: Array
) -> Uniformity:
    """Returns the measures of rotations from theta = 0 with initial `speeds` [rad/s], by quadrature
    over theta. `speeds`, `inertia` [kg m^2] and the coefficients of the `potential` [J] broadcast
    to the shape of the result."""
    rates = _speeds(potential, np.asarray(inertia), speeds)
    return _measures(rates, speeds, 1.0 / rates)  # the spans are dt = dtheta/theta_dot


def _measures(speeds: Array, first: Array, spans: Array) -> Uniformity:
    """Returns the measures of turns that start with the speed `first` and have the `speeds` [rad/s]
    along the last axis. Each speed lasts for a time in proportion to `spans`."""
    weights = spans / spans.sum(axis=-1, keepdims=True)
    mean = (weights * speeds).sum(axis=-1)
    mean_square = (weights * speeds**2).sum(axis=-1)
    is_near = np.abs(speeds / first[..., None] - 1.0) <= NEAR_INITIAL_SPEED
    return Uniformity(
        spread=np.ptp(speeds, axis=-1) / np.abs(first),
        deviation=np.sqrt(np.maximum(mean_square - mean**2, 0.0)) / np.abs(mean),
        near=(weights * is_near).sum(axis=-1),
        period=2 * np.pi / np.abs(mean),
    )


def _speeds(potential: TrigonometricPotential, inertia: Array, first: Array) -> Array:
    """Returns the speeds [rad/s] at ANGLES_OF_TURN angles of turns that start with the speed
    `first`, along the last axis; NaN if the motion does not turn over."""
    a, b, c = (
        np.asarray(double(x))[..., None] for x in (potential.a, potential.b, potential.c)
    )
    theta = np.arange(ANGLES_OF_TURN) * (2 * np.pi / ANGLES_OF_TURN)
    energies = np.asarray(TrigonometricPotential(a, b, c).value(theta))
    squares = first[..., None] ** 2 - 2 * (energies - energies[..., :1]) / inertia[..., None]
    turns_over = squares.min(axis=-1, keepdims=True) > 0.0
    return np.sqrt(np.where(turns_over, squares, np.nan))
