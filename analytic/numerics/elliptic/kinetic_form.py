"""The kinetic energy as a quadratic form on the circle, and the two points that make it even.

With phi measured from a saddle of V and n = (cos phi, sin phi, 1), the energy E above that saddle
leaves E - (V - V(saddle)) = Q(n) = E n3^2 + (n3 - n1)(l.n). In X e_p + Y e_q, with e_p and e_q the
half-angle vectors (sin, cos)(phi/2) of two points p and q chosen by an eigenvector of Q, it is
g4 X^4 + g2 X^2 Y^2 + g0 Y^4.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.quad import Quad, choose, double, everywhere, quad

Vector = tuple[Quad, Quad, Quad]
Direction = tuple[Quad, Quad]  # (sin, cos) of phi/2
_ZERO = quad(0.0)
_ONE = quad(1.0)


def slopes_at(potential: TrigonometricPotential, saddle: Quad) -> Vector:
    """l in V(saddle) - V(saddle + phi) = (1 - cos phi) (l1 cos phi + l2 sin phi + l3)."""
    sine, cosine = np.sin(saddle), np.cos(saddle)
    first = potential.a * (cosine - sine) * (cosine + sine)
    return (
        first,
        -2 * potential.a * sine * cosine,
        first - potential.b * sine - potential.c * cosine,
    )


def fall(slopes: Vector, phi: Quad) -> Quad:
    """V(saddle) - V(saddle + phi), without the difference of two potentials."""
    l1, l2, l3 = slopes
    sine, cosine = np.sin(phi / 2), np.cos(phi / 2)
    rise = sine * sine
    return 2 * rise * (l1 * (1 - 2 * rise) + 2 * l2 * sine * cosine + l3)


def diagonal(energy: Quad, slopes: Vector, real: Any) -> tuple[Direction, Direction, Vector]:
    """Fixed points p and q (see `_fixed_points`) and g4, g2, g0 of Q along X e_p + Y e_q; the odd
    terms vanish by the choice of p and q; Q(p) <= Q(q), and q is less than pi ahead of p."""
    p, q = _fixed_points(energy, slopes, real)
    pp, pq, qq = _products(p, p), _products(p, q), _products(q, q)
    on_p, middle, on_q = (_weighed(slopes, product) for product in (pp, pq, qq))
    mixed = energy * pp[2] * qq[2] + (pp[3] * on_q + qq[3] * on_p) / 2
    g4 = energy * pp[2] ** 2 + pp[3] * on_p
    g2 = 2 * mixed + 4 * (energy * pq[2] ** 2 + pq[3] * middle)
    g0 = energy * qq[2] ** 2 + qq[3] * on_q
    swap = g0 < g4
    p, q = chosen(swap, q, p), chosen(swap, p, q)
    q = chosen(cross(p, q) < 0, (-q[0], -q[1]), q)
    return p, q, (choose(swap, g0, g4), g2, choose(swap, g4, g0))


def _products(first: Direction, second: Direction) -> tuple[Quad, Quad, Quad, Quad]:
    """Cosine and sine of the sum of two directions, cosine of their difference, twice the product
    of the sines."""
    (x1, y1), (x2, y2) = first, second
    return y1 * y2 - x1 * x2, x1 * y2 + x2 * y1, x1 * x2 + y1 * y2, 2 * x1 * x2


def _weighed(slopes: Vector, product: tuple[Quad, Quad, Quad, Quad]) -> Quad:
    return slopes[0] * product[0] + slopes[1] * product[1] + slopes[2] * product[2]


def _fixed_points(energy: Quad, slopes: Vector, real: Any) -> tuple[Direction, Direction]:
    """(sin, cos)(phi/2) of the two points whose exchange leaves Q as it is, from the eigenvector
    of the pencil S - lambda diag(1, 1, -1), S the matrix of Q, that stays away from the double
    eigenvalue -kappa/2 of the separatrix. `real`: all three eigenvalues are."""
    # Each column is the eigenvector; the longest is the best conditioned.
    columns = _adjugate(energy, slopes, _eigenvalue(energy, slopes, real))
    w1, w2, w3 = (abs(double(column[i])) for i, column in enumerate(columns))
    best = chosen(w2 > w3, columns[1], columns[2])
    v1, v2, v3 = chosen((w1 >= w2) & (w1 >= w3), columns[0], best)
    free = (w1 == 0.0) & (w2 == 0.0) & (w3 == 0.0)  # V is constant: any point is one
    v2 = choose(free, _ONE, v2)
    root_disc = np.sqrt(positive(v1 * v1 + v2 * v2 - v3 * v3))
    far = choose(v2 < 0, v2 - root_disc, v2 + root_disc)
    return unit(v3 - v1, far), unit(far, v1 + v3)


def _adjugate(energy: Quad, slopes: Vector, root: Quad) -> tuple[Vector, Vector, Vector]:
    """Columns of the adjugate of the pencil at an eigenvalue."""
    l1, l2, l3 = slopes
    n11, n12, n13 = -l1 - root, -l2 / 2, (l1 - l3) / 2
    n22, n23, n33 = -root, l2 / 2, energy + l3 + root
    c12, c13, c23 = n13 * n23 - n12 * n33, n12 * n23 - n13 * n22, n12 * n13 - n11 * n23
    return (
        (n22 * n33 - n23 * n23, c12, c13),
        (c12, n11 * n33 - n13 * n13, c23),
        (c13, c23, n11 * n22 - n12 * n12),
    )


def _eigenvalue(energy: Quad, slopes: Vector, real: Any) -> Quad:
    """The root of lambda (lambda + kappa/2)^2 + E (lambda^2 + l1 lambda - l2^2/4) that is the
    largest of three real ones, or the only real one; kappa = l1 + l3."""
    l1, l2, l3 = slopes
    half, turn = (l1 + l3) / 2, l2 * l2 / 4
    c2, c1, c0 = half + half + energy, half * half + energy * l1, -energy * turn
    root = quad(_cubic_root(double(c2), double(c1), double(c0), real))
    for _ in range(60):
        shifted = root + half
        value = root * shifted * shifted + energy * (root * (root + l1) - turn)
        slope = shifted * (shifted + root + root) + energy * (root + root + l1)
        step = value / choose(slope == 0, _ONE, slope)
        root = root - step
        if everywhere(abs(step) <= 1e-22 * abs(root)):
            break
    return root


def _cubic_root(c2: Any, c1: Any, c0: Any, real: Any) -> Any:
    """In double a root of x^3 + c2 x^2 + c1 x + c0: just above the largest of three real ones, so
    that Newton's method falls monotonically even to a double root, or near the only real one."""
    shift = c2 / 3
    p, q = shift * shift - c1 / 3, (2 * shift * shift - c1) * shift + c0  # x^3 - 3 p x + q
    sign = choose(real | (q < 0), 1.0, -1.0)
    cube = (((q * q - 4 * p**3 + 0j) ** 0.5) - sign * q) / 2  # Cardano's, nothing cancelling
    w = choose(cube == 0, 1.0, cube) ** (1 / 3)
    return (sign * (w + p / w)).real - shift + choose(real, 3e-8, 0.0) * (abs(shift) + abs(w))


def positive(x: Quad) -> Quad:
    return choose(x > 0, x, _ZERO)


def chosen(condition: Any, u: Any, v: Any) -> Any:
    return tuple(choose(condition, x, y) for x, y in zip(u, v, strict=True))


def unit(x: Quad, y: Quad) -> Direction:
    length = np.sqrt(x * x + y * y)
    return x / length, y / length


def cross(u: Direction, v: Direction) -> Quad:
    return u[0] * v[1] - u[1] * v[0]
