"""From a potential and a start to the constants of the closed form (see `motion`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.numerics.elliptic.jacobi_functions import half_turn, time_of_point
from plumbob.analytic.numerics.elliptic.kinetic_form import (
    Direction,
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
    a, b, c, inertia, theta, theta_dot, rise, from_top = _broadcast(
        *(potential.a, potential.b, potential.c),
        *(inertia, theta, theta_dot, excess, theta_from_top),
    )
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
        level = _level(angles, slopes, above)
        return _motion(potential, inertia, theta, np.logical_not(theta_dot < 0), kinetic, level)


def _broadcast(*values: Any) -> Sequence[Quad]:
    """The values in 34 digits and of one shape; 0 where there is none."""
    numbers = [quad(0.0 if value is None else value) for value in values]
    return np.broadcast_arrays(*numbers) if any(np.ndim(v) for v in numbers) else numbers


@dataclass(frozen=True)
class _Level:
    """The energy [J] above the nearest `saddle` [rad] of V, and which motions it allows."""

    saddle: Quad
    slopes: Vector
    energy: Quad
    rotation: Any
    two_pairs: Any


def _level(angles: Vector, slopes: tuple[Vector, Vector], above: tuple[Quad, Quad]) -> _Level:
    """The level over the saddle that is nearest in energy; `angles` as `_landscape` gives them,
    `slopes` and the energies `above` the two saddles."""
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


@dataclass(frozen=True)
class _Quartic:
    """Q = g4 X^4 + g2 X^2 Y^2 + g0 Y^4 in X e_p + Y e_q, and the regime of its motion."""

    p: Direction
    q: Direction
    across: Quad  # sine of half the angle from q to p
    along: Quad  # its cosine
    g4: Quad
    g2: Quad
    g0: Quad
    rotation: Any
    two_pairs: Any
    between: Any

    @classmethod
    def of(cls, level: _Level) -> _Quartic:
        p, q, (g4, g2, g0) = diagonal(level.energy, level.slopes, level.rotation | level.two_pairs)
        between = (level.energy == 0) & (abs(g0) + abs(g4) <= 1e-28 * abs(g2))
        return cls(
            *(p, q, cross(p, q), p[0] * q[0] + p[1] * q[1], g4, g2, g0),
            rotation=level.rotation & np.logical_not(between),
            two_pairs=level.two_pairs,
            between=between,
        )

    @property
    def size(self) -> Quad:
        """|g4|."""
        return abs(self.g4)

    @property
    def one_pair(self) -> Any:
        """Whether the motion is a libration between the only two turning points."""
        return np.logical_not(self.rotation | self.two_pairs | self.between)


@dataclass(frozen=True)
class _Start:
    """The start as z = x/y, y >= 0; `square` z^2, `drive` z'^2 and `offset` z^2 - |g2|/(2 |g4|),
    in units of |g4|. They, not the energy, keep the digits of a small swing."""

    x: Quad
    y: Quad
    square: Quad
    drive: Quad
    offset: Quad

    @classmethod
    def of(cls, quartic: _Quartic, half: Quad, kinetic: Quad) -> _Start:
        """From `half` the angle from the saddle [rad] and the `kinetic` energy [J]."""
        direction = (np.sin(half), np.cos(half))
        x, y = cross(direction, quartic.q), cross(quartic.p, direction)
        down = y < 0
        x, y = choose(down, -x, x), choose(down, -y, y)
        square, size = (x / y) ** 2, quartic.size
        drive = positive(kinetic) * (quartic.across / y) ** 4 / size
        return cls(x, y, square, drive, square - abs(quartic.g2) / (size + size))

    @property
    def side(self) -> Any:
        """Sign of z."""
        return choose(self.x < 0, -1.0, 1.0)


@dataclass(frozen=True)
class _Factors:
    """Factors of the biquadratic: its discriminant's root, its two roots `plus` and `minus`, and
    A^2 and |B^2|, `large` and `small`, chosen from them."""

    disc: Quad
    plus: Quad
    minus: Quad
    large: Quad
    small: Quad

    @classmethod
    def of(cls, quartic: _Quartic, start: _Start) -> _Factors:
        g4, g2, g0, size = quartic.g4, quartic.g2, quartic.g0, quartic.size
        root = np.sqrt(positive(g2 * g2 - 4 * g0 * g4))
        apart = 2 * size * np.sqrt(start.offset * start.offset + start.drive)
        disc = choose(quartic.two_pairs, apart, root)
        plus = (abs(g2) + disc) / 2
        minus = abs(g0) * size / plus
        falling = quartic.one_pair & (g2 < 0)
        return cls(disc, plus, minus, choose(falling, minus, plus), choose(falling, plus, minus))


def _motion(
    potential: TrigonometricPotential,
    inertia: Quad,
    theta: Quad,
    forward: Any,
    kinetic: Quad,
    level: _Level,
) -> EllipticMotion:
    """The closed form from its level and start."""
    quartic = _Quartic.of(level)
    start = _Start.of(quartic, (theta - level.saddle) / 2, kinetic)
    factors, between = _Factors.of(quartic, start), quartic.between
    a = np.sqrt(choose(quartic.one_pair, factors.plus + factors.minus, factors.plus))
    b = choose(level.energy == 0, _ZERO, np.sqrt(factors.small))  # a separatrix, not round-off
    scale, sense, tau0 = _amplitude(quartic, start, factors, forward, a, b)
    turn, s = half_turn(a, b), np.sqrt(inertia + inertia) * quartic.across
    ahead = start.x * quartic.along + start.y
    resting = _at_rest(potential, theta, kinetic)
    a = choose(between, -sense * a, a)
    return EllipticMotion(
        potential=potential,
        inertia=inertia,
        theta0=theta,
        kinetic=kinetic,
        forward=forward,
        excess=level.energy,
        rest=resting,
        rotation=quartic.rotation,
        two_pairs=quartic.two_pairs,
        between=between,
        across=quartic.across,
        along=quartic.along,
        origin=theta - 2 * np.arctan2(start.x * quartic.across, ahead),
        scale=choose(between, start.x / start.y, scale),
        modulus=factors.disc / factors.plus,  # for two_pairs
        a=choose(resting, _ONE, a),  # at rest there is no time scale
        b=choose(resting, _ONE, b),
        s=s,
        half=double(turn),
        tau0=choose(resting | between, 0.0, tau0),
        period=s * turn * choose(quartic.one_pair, 2.0, 1.0),
    )


def _amplitude(
    quartic: _Quartic, start: _Start, factors: _Factors, forward: Any, a: Quad, b: Quad
) -> tuple[Quad, Any, Any]:
    """Scale of z, the sign of its motion, and the amplitude time of the start, in double."""
    rotation, two_pairs, size = quartic.rotation, quartic.two_pairs, quartic.size
    lift = start.drive / (start.square + factors.small / size)
    reach = choose(two_pairs, factors.large / size, start.square + lift)
    scale = choose(rotation, np.sqrt(quartic.g0 / factors.large), start.side * np.sqrt(reach))
    doubled = unit(np.sqrt(start.drive), start.offset)
    libration = unit(np.sqrt(lift), abs(start.x / start.y))
    sine, cosine = chosen(two_pairs, _halved(*doubled), libration)
    sine, cosine = chosen(rotation, unit(start.x / scale, start.y), (sine, cosine))
    sense = choose(rotation, 1.0, choose(forward, -start.side, start.side))
    return scale, sense, sense * time_of_point(sine, cosine, a, b)


def _at_rest(potential: TrigonometricPotential, theta: Quad, kinetic: Quad) -> Any:
    """Whether the start is an equilibrium, to 34 digits."""
    balance = abs(potential.slope(theta))
    return (abs(kinetic) <= 1e-60 * potential.scale) & (balance <= 1e-30 * potential.scale)


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
