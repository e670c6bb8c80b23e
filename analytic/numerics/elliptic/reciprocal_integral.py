"""The integral of 1/(1 + f dn) - 1/(1 + f) over time: the elliptic integral of the third kind less
its even growth, free of cancellation for 0 <= f <= 1.

With k1 = (A - B)/(A + B), the first step of Landen's transformation (DLMF 22.7.4), and s = sn of
(A + B)/2 tau with modulus k1, dn = (1 - k1 s^2)/(1 + k1 s^2), so that

    1/(1 + f dn) = [1 + (k1 - g) s^2/(1 + g s^2)]/(1 + f),    g = k1 (1 - f)/(1 + f) <= k1:

every term is positive. The integral of s^2/(1 + g s^2) is s^3 R_J/3 (DLMF 19.25.14). The even
growth, tau/(1 + f), is left out: a quarter turn may take 10^20 times as long as the motion that is
asked for, and the motion would be the difference of two integrals that agree in all digits of a
double.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.elliptic.jacobi_functions import half_turn, jacobi
from plumbob.analytic.numerics.quad import Quad, double, quad
from plumbob.analytic.reference import Array

# In a time 1/A: the integrand is smooth within pi/2 of that beside the real axis (DLMF 22.4), and
# the rule's error 1e-38.
POINTS = 9
_FADED = 350.0  # A tau at which sech^2 is next to the smallest double


@dataclass(frozen=True)
class ReciprocalIntegral:
    """Integral over tau [s] from 0 of 1/(1 + f dn) - 1/(1 + f), dn of A tau with the modulus
    1 - B^2/A^2; A, B [1/s], 0 <= B <= A > 0, and 0 <= f <= 1 with its distance from 1, to 34
    digits."""

    a: Quad
    b: Quad
    f: Quad
    below_one: Quad  # 1 - f

    def at(self, tau: Array, factor: Quad) -> Array:
        """A `factor` times the integral [s] at `tau` [s], shape (n,), at most a quarter turn either
        way. The factor may be as large as the integral is small."""
        import scipy.special

        mean = (self.a + self.b) / 2
        geometric = np.sqrt(self.a * self.b)
        rate = double(mean)
        begun = tau if double(geometric) else np.clip(tau, -_FADED / rate, _FADED / rate)
        s, c, d = jacobi(begun, rate, double(geometric))
        modulus = (self.a - self.b) / (self.a + self.b) / (1 + self.f)  # k1/(1 + f)
        # k1 - g
        g = double(modulus * self.below_one)
        weight = factor * self.f / (1 + self.f)
        third = s**3 / 3 * scipy.special.elliprj(c * c, d * d, 1.0, 1.0 + g * s * s)
        faded = double(weight) * (tau - begun)  # dn is 0 there
        return np.asarray(double(2 * weight * modulus / mean) * third + faded)

    @property
    def over_half_turn(self) -> Quad:
        """The integral [s] over a half turn, in which dn goes through its period, to 34 digits, for
        B > 0: by the trapezoidal rule, which converges geometrically."""
        length = half_turn(self.a, self.b)
        count = math.ceil(POINTS * double(self.a * length))
        dn = jacobi(length * quad(np.arange(count, dtype=float)) / count, self.a, self.b)[2]
        mean = ((1 - dn) / (1 + self.f * dn)).sum() / count
        return length * mean * self.f / (1 + self.f)
