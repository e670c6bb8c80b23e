"""Jacobi's functions sn, cn, dn of A tau, parameter m = 1 - B^2/A^2, and their inverse.

0 <= B <= A. Each function has full relative accuracy, for B down to 0. `scipy.special.ellipj`
takes m alone and loses digits of the period if 1 - m < 1e-10; A and B keep these digits. The angle
chi = am(A tau) solves dchi/dtau = sqrt(A^2 cos^2 chi + B^2 sin^2 chi).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbob.analytic.numerics.quad import PI, Quad, choose, double, quad
from plumbob.analytic.reference import Array

_STEPS = 20  # steps that suffice for any B/A > 0: the first steps halve the logarithm of B/A


def _means(a: Any, b: Any, near: float) -> list[tuple[Any, Any, Any]]:
    """Returns the steps of the arithmetic-geometric mean of a and b > 0, elementwise (DLMF 19.8.1).

    Each step is an arithmetic mean, a geometric mean and half their sum. The steps end when the two
    means agree to the relative difference `near`.
    """
    steps = []
    for _ in range(_STEPS):
        half_sum = (a + b) / 2
        steps.append((a, b, half_sum))
        if np.all(abs(a - b) <= near * a):  # convergence is quadratic
            break
        a, b = half_sum, np.sqrt(a * b)
    return steps


def half_turn(a: Quad, b: Quad) -> Quad:
    """Returns the time tau in which chi advances by pi, pi / AGM(A, B), to 34 digits; infinite for
    B = 0."""
    endless = b == 0
    mean = _means(a, choose(endless, a, b), 1e-16)[-1][-1]
    return choose(endless, quad(np.inf), PI / mean)


def jacobi(tau: Any, a: Any, b: Any) -> tuple[Array, Array, Array]:
    """Returns sn, cn and dn by the descending Landen transformation (DLMF 22.7.2 to 22.7.4).

    The transformation acts on the ratio cn/sn and on dn, so that nothing is subtracted. Arguments
    broadcast. To keep its digits, tau should be within a turn or two.
    """
    endless = b == 0.0
    steps = _means(a, choose(endless, a, b), 4e-16)  # the next two means would differ by 1e-32
    angle = steps[-1][-1] * tau
    sine = np.sin(angle)
    small = np.abs(double(sine)) < 1e-100
    divisor = sine
    if np.any(small):  # a smaller divisor could overflow
        divisor = choose(small, np.copysign(1e-100, double(sine)), sine)
    ratio = np.cos(angle) / divisor
    dn: Any = 1.0
    for mean, geometric, half_sum in reversed(steps):
        square = ratio * ratio * half_sum
        ratio = ratio * dn * (half_sum / mean)
        dn = (square + geometric) / (square + mean)
    sn = np.copysign(1.0, double(sine)) / np.sqrt(1.0 + ratio * ratio)
    cn = ratio * sn
    sn = choose(sine == 0, sine, sn)
    if np.any(endless):
        sn = np.where(endless, np.tanh(a * tau), sn)
        cn = np.where(endless, _hyperbolic_secant(a * tau), cn)
        dn = np.where(endless, _hyperbolic_secant(a * tau), dn)
    return sn, cn, dn


def _hyperbolic_secant(x: Any) -> Any:
    """Returns 1/cosh(x), without overflow for large x."""
    decay = np.exp(-abs(x))
    return 2 * decay / (1 + decay * decay)


def time_of_point(sine: Any, cosine: Any, a: Any, b: Any) -> Any:
    """Returns the time tau(chi) for |chi| <= pi/2, by Carlson's R_F (DLMF 19.25.5).

    chi is given by its sine and its cosine, each with full relative accuracy.
    """
    import scipy.special

    c2 = double((a * cosine) ** 2)
    s2 = double((b * sine) ** 2)
    return double(sine) * scipy.special.elliprf(c2, c2 + s2, double(a) ** 2)
