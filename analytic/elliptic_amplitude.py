"""The amplitude equation dchi/dtau = sqrt(A^2 cos^2 chi + B^2 sin^2 chi), 0 <= B <= A: its period
by the arithmetic-geometric mean, its solution and the inverse of that, for B down to 0.

chi(tau) is Jacobi's am(A tau | 1 - B^2/A^2). scipy's `ellipj` takes the parameter m alone and loses
its period once 1 - m < 1e-10; A and B keep what m rounds away.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.special

from analytic.quad import PI, Quad, double, quad
from analytic.reference import Array


def arithmetic_geometric_mean(a: Any, b: Any, steps: int = 11) -> Any:
    """AGM(a, b) elementwise, in the arithmetic given (DLMF 19.8.1); 11 steps reach 34 digits for
    b/a >= 1e-30, where the first steps only halve the ratio's logarithm."""
    for _ in range(steps):
        a, b = (a + b) / 2, np.sqrt(a * b)
    return a


def half_turn(a: Quad, b: Quad) -> Quad:
    """Time tau in which chi advances by pi: pi / AGM(A, B); infinite for B = 0."""
    separatrix = b == 0
    mean = arithmetic_geometric_mean(a, np.where(separatrix, a, b))
    return np.where(separatrix, quad(np.inf), PI / mean)


def amplitude(tau: Any, a: Any, b: Any) -> Any:
    """chi(tau) with chi(0) = 0 (DLMF 22.20.6, with the arcsine as a two-argument arctangent, whose
    error stays at round-off where its argument tends to 1); for B = 0 Gudermann's function.

    Arguments broadcast; tau should be reduced to a turn or two.
    """
    ladder = []
    mean, geometric = a, b
    for _ in range(8):
        mean, geometric, half = (
            (mean + geometric) / 2,
            np.sqrt(mean * geometric),
            (mean - geometric) / 2,
        )
        ladder.append((mean, geometric, half))
        if np.all(np.abs(half) <= 1e-9 * mean):  # the next would be below 1e-18
            break
    chi = 2.0 ** len(ladder) * mean * tau
    for mean, geometric, half in reversed(ladder):
        sine, cosine = np.sin(chi), np.cos(chi)
        adjacent = np.sqrt((mean * cosine) ** 2 + (geometric * sine) ** 2)
        chi = (chi + np.arctan2(half * sine, adjacent)) / 2
    if np.any(b == 0.0):
        chi = np.where(b == 0.0, 2 * np.arctan(np.tanh(a * tau / 2)), chi)
    return chi


def time_of(chi: Array, a: Array, b: Array, half: Array) -> Array:
    """tau(chi), the inverse of `amplitude`, by Carlson's R_F (DLMF 19.25.5); `half` is the double
    of `half_turn`, needed only where |chi| > pi/2."""
    turns = np.rint(chi / np.pi)
    sine, cosine = np.sin(chi - turns * np.pi), np.cos(chi - turns * np.pi)
    return turns * half + time_of_point(sine, cosine, a, b)


def time_of_point(sine: Any, cosine: Any, a: Any, b: Any) -> Array:
    """tau(chi) for |chi| <= pi/2 given by its sine and cosine, each accurate on its own."""
    c2, s2 = double((a * cosine) ** 2), double((b * sine) ** 2)
    first: Array = double(sine) * scipy.special.elliprf(c2, c2 + s2, double(a) ** 2)
    return first
