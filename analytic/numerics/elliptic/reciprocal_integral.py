"""The integral of 1/(1 + f dn) - 1/(1 + f) over time, free of cancellation for 0 <= f <= 1.

It is an elliptic integral of the third kind, less its steady growth tau/(1 + f).

By the first step of Landen's transformation (DLMF 22.7.4), with k1 = (A - B)/(A + B) and s = sn of
(A + B)/2 tau with modulus k1, dn = (1 - k1 s^2)/(1 + k1 s^2), so that

    1/(1 + f dn) = [1 + (k1 - g) s^2/(1 + g s^2)]/(1 + f),    g = k1 (1 - f)/(1 + f) <= k1:

every term is positive. The integral of s^2/(1 + g s^2) is s^3 R_J/3 (DLMF 19.25.14). The steady
growth is left out for its size: a quarter turn may take 10^20 times as long as the motion that is
evaluated. With the growth, the motion would be the difference of two integrals that agree in all
digits of a double.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.elliptic.jacobi_functions import half_turn, jacobi
from plumbob.analytic.numerics.quad import Quad, double, quad
from plumbob.analytic.reference import Array

# Points of the trapezoidal rule in a time 1/A. The integrand is analytic in the strip |Im t| <
# pi/(2A) (DLMF 22.4), so that the rule's error is 1e-38.
TRAPEZOID_POINTS = 9
_LONGEST_PHASE = 350.0  # A tau at which sech^2 is close to the smallest double


@dataclass(frozen=True)
class ReciprocalIntegral:
    """The integral of 1/(1 + f dn) - 1/(1 + f) over tau [s] from 0. Here dn is Jacobi's function of
    A tau with the parameter 1 - B^2/A^2; A is `a`, B is `b`. All numbers have 34 digits."""

    a: Quad  # A > 0 [1/s]
    b: Quad  # B [1/s], 0 <= B <= A
    f: Quad  # 0 <= f <= 1
    below_one: Quad  # 1 - f

    def at(self, tau: Array, factor: Quad) -> Array:
        """Returns a `factor` times the integral [s] at `tau` [s], shape (n,), at most a quarter
        turn either way. The factor may be as large as the integral is small."""
        import scipy.special

        mean = (self.a + self.b) / 2
        geometric = np.sqrt(self.a * self.b)
        rate = double(mean)
        longest = _LONGEST_PHASE / rate
        clipped = tau if double(geometric) else np.clip(tau, -longest, longest)
        s, c, d = jacobi(clipped, rate, double(geometric))
        modulus = (self.a - self.b) / (self.a + self.b) / (1 + self.f)  # k1/(1 + f)
        g = double(modulus * self.below_one)
        weight = factor * self.f / (1 + self.f)
        third = s**3 / 3 * scipy.special.elliprj(c * c, d * d, 1.0, 1.0 + g * s * s)
        faded = double(weight) * (tau - clipped)  # dn is 0 in the clipped time
        # k1 - g is 2 f times `modulus`, without a difference.
        return np.asarray(double(2 * weight * modulus / mean) * third + faded)

    @property
    def over_half_turn(self) -> Quad:
        """The integral of the class [s] over a half turn, which is one period of dn, to 34 digits.
        `b` must be above 0: at 0 a half turn takes for ever.

        The trapezoidal rule converges geometrically.
        """
        length = half_turn(self.a, self.b)
        count = math.ceil(TRAPEZOID_POINTS * double(self.a * length))
        dn = jacobi(length * quad(np.arange(count, dtype=float)) / count, self.a, self.b)[2]
        mean = ((1 - dn) / (1 + self.f * dn)).sum() / count
        return length * mean * self.f / (1 + self.f)
