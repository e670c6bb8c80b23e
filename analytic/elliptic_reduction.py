"""From a potential and a start to the constants of the closed form (see elliptic_motion)."""

from __future__ import annotations

from typing import Any

import numpy as np

from analytic.elliptic_amplitude import half_turn, time_of_point
from analytic.elliptic_motion import EllipticMotion
from analytic.quad import Quad, double, quad
from analytic.reference import Array
from analytic.trigonometric_potential import TrigonometricPotential, critical_points

Vector = tuple[Quad, Quad, Quad]


def solve(
    potential: TrigonometricPotential,
    inertia: Any,
    theta: Any,
    theta_dot: Any,
    excess: Any = None,
) -> EllipticMotion:
    """Solve I theta'' = -V'(theta) from theta [rad] and theta_dot [rad/s]; all arguments broadcast.

    `excess` [J], where given, is the energy above the highest barrier, in place of the magnitude
    of theta_dot, whose sign it keeps. Source: Sudakov 2015, eqs. 15 and 16, inverted.
    """
    given = (
        potential.a,
        potential.b,
        potential.c,
        inertia,
        theta,
        theta_dot,
        0.0 if excess is None else excess,
    )
    a, b, c, inertia, theta, theta_dot, rise = np.broadcast_arrays(*(quad(v) for v in given))
    potential = TrigonometricPotential(a, b, c)
    with np.errstate(all="ignore"):  # branches not taken, and infinite periods
        highest, lower, shallow = _landscape(potential)
        above = [_energy_above(potential, inertia, theta, theta_dot, s) for s in (highest, lower)]
        if excess is not None:
            above = [rise, rise + potential.value(highest) - potential.value(lower)]
        depth = potential.value(lower) - potential.value(shallow)
        rotation = np.asarray(above[0] >= 0)
        two_pairs = np.asarray((above[1] < 0) & (above[1] > -depth))
        nearest = np.abs(above[1]) < np.abs(above[0])  # false where there is no lower barrier
        saddle = np.where(nearest, lower, highest)
        energy = np.where(nearest, above[1], above[0])
        slopes = _slopes(potential, saddle)
        p, q = _fixed_points(energy, slopes, rotation | two_pairs)
        g4, g2, g0 = _biquadratic(energy, slopes, p, q)
        swap = g0 < g4  # p is the fixed point with the smaller kinetic energy
        p, q = (
            tuple(np.where(swap, v, u) for u, v in zip(*pair, strict=True))
            for pair in ((p, q), (q, p))
        )
        g4, g0 = np.where(swap, g0, g4), np.where(swap, g4, g0)
        q = tuple(np.where(_cross(p, q) < 0, -v, v) for v in q)

        disc = np.sqrt(np.maximum(g2 * g2 - 4 * g0 * g4, quad(0.0)))
        plus = (np.abs(g2) + disc) / 2
        minus = np.abs(g0 * g4) / plus
        one_pair = ~(rotation | two_pairs)
        large = np.where(one_pair & (g2 < 0), minus, plus)  # A^2 of the biquadratic's factors
        small = np.where(one_pair & (g2 < 0), plus, minus)  # |B^2|
        z_scale = np.sqrt(np.where(rotation, g0 / large, large / np.abs(g4)))
        big = np.sqrt(np.where(one_pair, large + small, large))
        little = np.where(energy == 0, quad(0.0), np.sqrt(small))  # a separatrix, not round-off
        s = np.sqrt(2 * inertia) * _cross(p, q)

        half_angle = (theta - saddle) / 2
        start = (np.sin(half_angle), np.cos(half_angle))
        x, y = _cross(start, q), _cross(p, start)
        side = np.where(rotation | (x * y >= 0), 1.0, -1.0)
        forward = np.logical_not(theta_dot < 0)
        point = _start_point(
            rotation, two_pairs, x, y, z_scale, disc / np.abs(g4), small / np.abs(g4)
        )
        sense = np.where(rotation, 1.0, np.where(forward, -side, side))
        period = s * half_turn(big, little) * np.where(one_pair, 2.0, 1.0)
        rest = (
            (theta_dot == 0)
            & (excess is None)
            & (np.abs(double(potential.slope(theta))) <= 1e-30 * potential.scale)
        )
        return EllipticMotion(
            potential, inertia, theta, forward, saddle, energy, rest, rotation, two_pairs,
            p[0], p[1], q[0], q[1], side * z_scale, side * np.sqrt(small / np.abs(g4)),
            big, little, s, double(sense) * time_of_point(*point, big, little), period,
        )  # fmt: skip


def _landscape(potential: TrigonometricPotential) -> tuple[Quad, Quad, Quad]:
    """Angles of the highest maximum of V (0 for a constant V), of the other one, and of the
    shallower of two wells (NaN where there is one of each)."""
    points = critical_points(potential)
    spread = TrigonometricPotential(
        *(v[..., None] for v in (potential.a, potential.b, potential.c))
    )
    value, curvature = double(spread.value(points)), double(spread.curvature(points))
    crests, wells = curvature < 0.0, curvature >= 0.0
    highest = _ranked(points, np.where(crests, value, np.nan), 0)
    shallow = _ranked(points, np.where(wells, value, np.nan), 0)
    return (
        np.where(crests.any(axis=-1), highest, quad(0.0)),
        _ranked(points, np.where(crests, value, np.nan), 1),
        np.where(wells.sum(axis=-1) > 1, shallow, quad(np.nan)),
    )


def _ranked(points: Quad, value: Array, rank: int) -> Quad:
    """The point with the highest `value` (rank 0) or the next one; NaN values do not count."""
    order = np.argsort(-value, axis=-1, kind="stable")[..., rank : rank + 1]
    best = np.take_along_axis(points, order, -1)[..., 0]
    return np.where(np.isfinite(value).sum(axis=-1) > rank, best, quad(np.nan))


def _slopes(potential: TrigonometricPotential, saddle: Quad) -> Vector:
    """l in V(saddle) - V(saddle + phi) = (1 - cos phi) (l1 cos phi + l2 sin phi + l3)."""
    sine, cosine = np.sin(saddle), np.cos(saddle)
    first = potential.a * (cosine - sine) * (cosine + sine)
    return (
        first,
        -2 * potential.a * sine * cosine,
        first - potential.b * sine - potential.c * cosine,
    )


def _energy_above(
    potential: TrigonometricPotential, inertia: Quad, theta: Quad, theta_dot: Quad, saddle: Quad
) -> Quad:
    """Energy above a saddle, without the difference of two potentials."""
    l1, l2, l3 = _slopes(potential, saddle)
    phi = theta - saddle
    fall = 2 * np.sin(phi / 2) ** 2 * (l1 * np.cos(phi) + l2 * np.sin(phi) + l3)
    return inertia * theta_dot**2 / 2 + np.where(np.isnan(double(saddle)), np.inf, -1.0) * fall


def _fixed_points(energy: Quad, slopes: Vector, real: Any) -> tuple[Any, Any]:
    """(sin, cos)(phi/2) of the two points whose exchange leaves Q as it is, from the eigenvector
    of the pencil S - lambda diag(1, 1, -1), S the matrix of Q, that stays away from the double
    eigenvalue -kappa/2 of the separatrix. `real`: all three eigenvalues are."""
    l1, l2, l3 = slopes
    root = _eigenvalue(energy, slopes, real)
    n11, n12, n13 = -l1 - root, -l2 / 2, (l1 - l3) / 2
    n22, n23, n33 = -root, l2 / 2, energy + l3 + root
    columns = (  # of the adjugate: each is the eigenvector; the longest is the best conditioned
        (n22 * n33 - n23 * n23, n13 * n23 - n12 * n33, n12 * n23 - n13 * n22),
        (n13 * n23 - n12 * n33, n11 * n33 - n13 * n13, n12 * n13 - n11 * n23),
        (n12 * n23 - n13 * n22, n12 * n13 - n11 * n23, n11 * n22 - n12 * n12),
    )
    weight = np.stack([np.abs(double(column[i])) for i, column in enumerate(columns)])
    best = np.argmax(weight, axis=0)
    v1, v2, v3 = (
        np.where(best == 0, columns[0][i], np.where(best == 1, columns[1][i], columns[2][i]))
        for i in range(3)
    )
    free = weight.max(axis=0) == 0.0  # V is constant: any point will do
    v2 = np.where(free, quad(1.0), v2)
    root_disc = np.sqrt(np.maximum(v1 * v1 + v2 * v2 - v3 * v3, quad(0.0)))
    far = np.where(v2 < 0, v2 - root_disc, v2 + root_disc)
    return _unit(v3 - v1, far), _unit(far, v1 + v3)


def _eigenvalue(energy: Quad, slopes: Vector, real: Any) -> Quad:
    """The root of lambda (lambda + kappa/2)^2 + E (lambda^2 + l1 lambda - l2^2/4) that is the
    largest of three real ones, or the only real one; kappa = l1 + l3."""
    l1, l2, l3 = slopes
    half = (l1 + l3) / 2
    e, d1, d2, d3 = (double(v) for v in (energy, l1, l2, l3))
    zero = 0.0 * e
    rows = (
        (-d1, -d2 / 2, (d1 - d3) / 2),
        (-d2 / 2, zero, d2 / 2),
        (-(d1 - d3) / 2, -d2 / 2, -(e + d3)),
    )
    matrix = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    values = np.linalg.eigvals(matrix).astype(complex)
    scale = np.abs(d1) + np.abs(d2) + np.abs(d3) + np.abs(e)
    apart = np.abs(values - np.roll(values, 1, -1)) * np.abs(values - np.roll(values, -1, -1))
    single = np.where(values.imag == 0.0, apart, -1.0)
    only: Array = np.take_along_axis(values.real, single.argmax(-1)[..., None], -1)[..., 0]
    # From above the largest root Newton's method falls monotonically, also towards a double one.
    root = quad(np.where(real, values.real.max(axis=-1) + 3e-8 * scale, only))
    for _ in range(60):
        shifted = root + half
        value = root * shifted**2 + energy * (root * (root + l1) - l2 * l2 / 4)
        slope = shifted * (shifted + 2 * root) + energy * (2 * root + l1)
        step = value / np.where(slope == 0, quad(1.0), slope)
        root = root - step
        if np.all(np.abs(double(step)) <= 1e-22 * np.abs(double(root)) + 1e-40 * scale):
            break
    return root


def _biquadratic(energy: Quad, slopes: Vector, p: Any, q: Any) -> Vector:
    """g4, g2, g0 of Q along X e_p + Y e_q; the odd terms vanish by the choice of p and q."""
    points = tuple(
        ((y1 * y2 - x1 * x2), (x1 * y2 + x2 * y1), (x1 * x2 + y1 * y2), 2 * x1 * x2)
        for (x1, y1), (x2, y2) in ((p, p), (q, q), (p, q))
    )
    l1, l2, l3 = slopes
    on_p, on_q, middle = (l1 * n[0] + l2 * n[1] + l3 * n[2] for n in points)
    (_, _, p3, p_rise), (_, _, q3, q_rise), (_, _, m3, m_rise) = points
    mixed = energy * p3 * q3 + (p_rise * on_q + q_rise * on_p) / 2
    return (
        energy * p3**2 + p_rise * on_p,
        2 * mixed + 4 * (energy * m3**2 + m_rise * middle),
        energy * q3**2 + q_rise * on_q,
    )


def _start_point(
    rotation: Any, two_pairs: Any, x: Quad, y: Quad, scale: Quad, gap: Quad, inner2: Quad
) -> tuple[Quad, Quad]:
    """(sin chi, cos chi) of the start, chi in [-pi/2, pi/2] when rotating, else in [0, pi/2]."""
    turn = np.where(y < 0, -1.0, 1.0)
    z = np.abs(x / y)
    cosine2 = np.where(two_pairs, (z * z - inner2) / gap, (z / scale) ** 2)
    cosine2 = np.where(scale == 0, quad(1.0), np.minimum(np.maximum(cosine2, quad(0.0)), quad(1.0)))
    sine, cosine = _unit(turn * x / scale, turn * y)
    return np.where(rotation, sine, np.sqrt(1 - cosine2)), np.where(
        rotation, cosine, np.sqrt(cosine2)
    )


def _unit(x: Quad, y: Quad) -> tuple[Quad, Quad]:
    length = np.sqrt(x * x + y * y)
    return x / length, y / length


def _cross(u: Any, v: Any) -> Quad:
    return u[0] * v[1] - u[1] * v[0]
