"""From a potential and a start to the constants of the closed form (see `motion`)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.numerics.elliptic.jacobi_functions import half_turn, time_of_point
from plumbob.analytic.numerics.elliptic.kinetic_form import (
    Vector,
    chosen,
    cross,
    diagonal,
    fall,
    positive,
    slopes_at,
    unit,
)
from plumbob.analytic.numerics.elliptic.motion import EllipticMotion
from plumbob.analytic.numerics.elliptic.trigonometric_potential import (
    TrigonometricPotential,
    critical_points,
)
from plumbob.analytic.numerics.quad import PI, Quad, choose, double, quad

_NONE, _ZERO, _ONE = quad(np.nan), quad(0.0), quad(1.0)


def solve(
    potential: TrigonometricPotential,
    inertia: Any,
    theta: Any,
    theta_dot: Any,
    excess: Any = None,
    theta_from_top: Any = None,
) -> EllipticMotion:
    """Solve I theta'' = -V'(theta) from theta [rad] and theta_dot [rad/s]; all arguments broadcast.

    `excess` [J], where given, is the energy above the highest barrier, in place of the magnitude
    of theta_dot, whose sign it keeps; `theta_from_top` [rad] is the start's angle from that
    barrier, on the turn that `theta` is nearest to. Source: Sudakov 2015, eqs. 15 and 16, inverted.
    """
    optional = (0.0 if v is None else v for v in (excess, theta_from_top))
    coefficients = (potential.a, potential.b, potential.c)
    given = [quad(v) for v in (*coefficients, inertia, theta, theta_dot, *optional)]
    if any(np.ndim(v) for v in given):
        given = list(np.broadcast_arrays(*given))
    a, b, c, inertia, theta, theta_dot, rise, from_top = given
    potential = TrigonometricPotential(a, b, c)
    with np.errstate(all="ignore"):  # branches not taken, and infinite periods
        angles = _landscape(potential)
        slopes = slopes_at(potential, angles[0]), slopes_at(potential, angles[1])
        if theta_from_top is not None:
            theta = _nearest_top(potential, angles, slopes[0], theta) + from_top
        reach = fall(slopes[0], theta - angles[0])
        if excess is None:
            kinetic = inertia * theta_dot * theta_dot / 2
            above = kinetic - reach, kinetic - fall(slopes[1], theta - angles[1])
        else:
            kinetic = rise + reach
            above = rise, rise - fall(slopes[1], angles[0] - angles[1])
        forward = np.logical_not(theta_dot < 0)
        level = _level(angles, slopes, above)
        return _motion(potential, inertia, theta, forward, kinetic, level)


@dataclass(frozen=True)
class _Level:
    """Where the energy lies: over which saddle, by how much [J], and what that allows."""

    saddle: Quad
    slopes: Vector
    energy: Quad
    rotation: Any
    two_pairs: Any


def _level(angles: Vector, slopes: tuple[Vector, Vector], above: tuple[Quad, Quad]) -> _Level:
    """The level by the saddle that the energy is nearer to; `angles` as `_landscape` gives them,
    `slopes` and the energy `above` of the two saddles."""
    highest, lower, shallow = angles
    depth = fall(slopes[1], shallow - lower)
    nearest = abs(above[1]) < abs(above[0])  # false where there is no lower barrier
    return _Level(
        choose(nearest, lower, highest),
        chosen(nearest, slopes[1], slopes[0]),
        choose(nearest, above[1], above[0]),
        rotation=above[0] >= 0,
        two_pairs=(above[1] < 0) & (above[1] > -depth),
    )


def _motion(
    potential: TrigonometricPotential,
    inertia: Quad,
    theta: Quad,
    forward: Any,
    kinetic: Quad,
    level: _Level,
) -> EllipticMotion:
    """The closed form from its level and start."""
    energy, rotation, two_pairs = level.energy, level.rotation, level.two_pairs
    p, q, (g4, g2, g0) = diagonal(energy, level.slopes, rotation | two_pairs)
    across, along = cross(p, q), p[0] * q[0] + p[1] * q[1]
    size = abs(g4)
    between = (energy == 0) & (abs(g0) + size <= 1e-28 * abs(g2))
    rotation = rotation & np.logical_not(between)
    one_pair = np.logical_not(rotation | two_pairs | between)

    half = (theta - level.saddle) / 2
    start = (np.sin(half), np.cos(half))
    x, y = cross(start, q), cross(p, start)
    down = y < 0
    x, y = choose(down, -x, x), choose(down, -y, y)
    square = (x / y) ** 2
    # z'^2 and z of the start, not the energy, have what a small swing leaves of its digits.
    drive = positive(kinetic) * (across / y) ** 4 / size
    offset = square - abs(g2) / (size + size)
    root = np.sqrt(positive(g2 * g2 - 4 * g0 * g4))
    disc = choose(two_pairs, 2 * size * np.sqrt(offset * offset + drive), root)
    plus = (abs(g2) + disc) / 2
    minus = abs(g0) * size / plus
    falling = one_pair & (g2 < 0)
    large = choose(falling, minus, plus)  # A^2 of the biquadratic's factors
    small = choose(falling, plus, minus)  # |B^2|
    a = np.sqrt(choose(one_pair, plus + minus, plus))
    b = choose(energy == 0, _ZERO, np.sqrt(small))  # a separatrix, not round-off
    s = np.sqrt(inertia + inertia) * across
    turn = half_turn(a, b)

    lift = drive / (square + small / size)
    reach = choose(two_pairs, large / size, square + lift)
    side = choose(x < 0, -1.0, 1.0)
    scale = choose(rotation, np.sqrt(g0 / large), side * np.sqrt(reach))
    doubled = unit(np.sqrt(drive), offset)
    sine, cosine = chosen(two_pairs, _halved(*doubled), unit(np.sqrt(lift), abs(x / y)))
    sine, cosine = chosen(rotation, unit(x / scale, y), (sine, cosine))
    sense = choose(rotation, 1.0, choose(forward, -side, side))
    tau0 = sense * time_of_point(sine, cosine, a, b)

    balance = abs(potential.slope(theta))
    rest = (abs(kinetic) <= 1e-60 * potential.scale) & (balance <= 1e-30 * potential.scale)
    a = choose(between, -sense * a, a)
    return EllipticMotion(
        potential=potential,
        inertia=inertia,
        theta0=theta,
        kinetic=kinetic,
        forward=forward,
        excess=energy,
        rest=rest,
        rotation=rotation,
        two_pairs=two_pairs,
        between=between,
        across=across,
        along=along,
        origin=theta - 2 * np.arctan2(x * across, x * along + y),
        scale=choose(between, x / y, scale),
        modulus=disc / plus,  # for two_pairs
        a=choose(rest, _ONE, a),  # at rest there is no time scale, nor anything to take place
        b=choose(rest, _ONE, b),
        s=s,
        half=double(turn),
        tau0=choose(rest | between, 0.0, tau0),
        period=s * turn * choose(one_pair, 2.0, 1.0),
    )


def _landscape(potential: TrigonometricPotential) -> Vector:
    """Angles of the highest maximum of V (0 for a constant V), of the other one, and of the
    shallower of two wells (NaN where there is one of each)."""
    points = critical_points(potential)
    coefficients = (potential.a, potential.b, potential.c)
    rough = TrigonometricPotential(*(np.asarray(double(v))[..., None] for v in coefficients))
    angles = double(points)
    value, curvature = rough.value(angles), rough.curvature(angles)
    crests = curvature < 0.0
    count, wells = crests.sum(axis=-1), (curvature >= 0.0).sum(axis=-1)
    height = value + crests * (4.0 * np.asarray(potential.scale)[..., None])  # crests before wells
    ranked = np.take_along_axis(points, np.argsort(-height, axis=-1, kind="stable"), -1)
    return (
        choose(count > 0, ranked[..., 0], _ZERO),
        choose(count > 1, ranked[..., 1], _NONE),
        choose(wells > 1, ranked[..., 2], _NONE),
    )


def _nearest_top(
    potential: TrigonometricPotential, angles: Vector, slopes: Vector, theta: Quad
) -> Quad:
    """Angle of the highest barrier, on the turn nearest to theta; of two equal ones the nearer."""
    highest, lower, _ = angles
    equal = abs(fall(slopes, lower - highest)) <= 1e-28 * potential.scale
    nearer = abs(_turned(lower - theta)) < abs(_turned(highest - theta))
    return theta + _turned(choose(equal & nearer, lower, highest) - theta)


def _turned(angle: Quad) -> Quad:
    """The angle less the whole turns that are nearest to it."""
    return angle - 2 * PI * quad(np.rint(double(angle) / (2 * np.pi)))


def _halved(sine: Quad, cosine: Quad) -> tuple[Quad, Quad]:
    """Sine and cosine of half an angle in [0, pi]."""
    half: tuple[Quad, Quad] = chosen(cosine < 0, unit(1 - cosine, sine), unit(sine, 1 + cosine))
    return half
