"""The potential V = -a sin^2(theta) - b sin(theta) - c cos(theta): values and critical points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from analytic.quad import PI, Quad, double, quad
from analytic.reference import Array

Kind = Literal["centre", "saddle", "degenerate"]


@dataclass(frozen=True)
class TrigonometricPotential:
    """Coefficients a, b, c [J] (any arithmetic, one shape) of Sudakov 2015, eq. 7."""

    a: Any
    b: Any
    c: Any

    def value(self, theta: Any) -> Any:
        """V(theta) [J]."""
        sine, cosine = np.sin(theta), np.cos(theta)
        return -(self.a * sine + self.b) * sine - self.c * cosine

    def slope(self, theta: Any) -> Any:
        """dV/dtheta [J/rad]."""
        return self.slope_and_curvature(theta)[0]

    def curvature(self, theta: Any) -> Any:
        """d^2V/dtheta^2 [J/rad^2]."""
        return self.slope_and_curvature(theta)[1]

    def slope_and_curvature(self, theta: Any) -> tuple[Any, Any]:
        """dV/dtheta and d^2V/dtheta^2 from one sine and one cosine."""
        sine, cosine = np.sin(theta), np.cos(theta)
        twice = 2 * self.a * sine + self.b
        slope = self.c * sine - twice * cosine
        return slope, twice * sine + (self.c - 2 * self.a * cosine) * cosine

    @property
    def scale(self) -> Array:
        """|a| + |b| + |c| [J], in double."""
        return double(np.abs(self.a) + np.abs(self.b) + np.abs(self.c))


def critical_points(potential: TrigonometricPotential) -> Quad:
    """Angles in (-pi, pi] where dV/dtheta = 0, in 34 digits, ascending, shape (..., 4); places
    without one, and a constant V, hold NaN."""
    a, b, c = (np.atleast_1d(double(x))[..., None] for x in (potential.a, potential.b, potential.c))
    shape = np.shape(potential.a)
    rough = TrigonometricPotential(a, b, c)
    exact = TrigonometricPotential(
        *(quad(np.atleast_1d(x))[..., None] for x in (potential.a, potential.b, potential.c))
    )
    theta = _approximate(rough)
    scale = rough.scale + (rough.scale == 0.0)
    with np.errstate(all="ignore"):
        for _ in range(3):
            slope, curvature = rough.slope_and_curvature(theta)
            theta = theta - slope / (curvature + (curvature == 0.0))
        fine = quad(theta)
        for _ in range(2):
            slope, curvature = exact.slope_and_curvature(fine)
            fine = fine - slope / (curvature + (curvature == 0.0))
        fine = np.where(b == 0.0, _symmetric(exact), fine)
        # What is no root, or not yet one, shows in the slope that is left.
        left = np.abs(double(exact.slope(fine))) > 1e-24 * scale
        fine = fine - 2 * PI * np.rint(fine / (2 * PI))
        fine = np.where(double(fine) <= -np.pi, fine + 2 * PI, fine)
        order = np.argsort(np.where(left, np.nan, double(fine)), axis=-1)
        fine = np.take_along_axis(np.where(left, quad(np.nan), fine), order, axis=-1)
        again = np.diff(double(fine), axis=-1, prepend=-np.inf) < 1e-13
    fine = np.where(again | (rough.scale == 0.0), quad(np.nan), fine)
    return fine.reshape((*shape, 4))


def kind(potential: TrigonometricPotential, theta: Quad) -> Kind:
    """Kind of the equilibrium at a critical point `theta`, a scalar."""
    curvature = float(double(potential.curvature(theta)))
    # At a pitchfork the curvature is what rounding of the coefficients leaves of zero.
    if abs(curvature) <= 4e-16 * float(potential.scale):
        return "degenerate"
    return "centre" if curvature > 0.0 else "saddle"


def _approximate(potential: TrigonometricPotential) -> Array:
    """Four starting angles, shape (n, 4): arguments of the roots of dV/dtheta in z = e^(i theta),
    -a z^4 + (c - ib) z^3 - (c + ib) z + a = 0, as eigenvalues of companion matrices."""
    a, b, c = (x[..., 0] for x in (potential.a, potential.b, potential.c))
    tiny = 1e-8 * (np.abs(b) + np.abs(c)) + (potential.scale[..., 0] == 0.0)
    lead = np.where(np.abs(a) > tiny, a, tiny)  # Newton's method removes what this changes
    companion = np.zeros((*a.shape, 4, 4), dtype=complex)
    companion[..., 1, 0] = companion[..., 2, 1] = companion[..., 3, 2] = 1.0
    companion[..., 0, 0] = (c - 1j * b) / lead
    companion[..., 0, 2] = -(c + 1j * b) / lead
    companion[..., 0, 3] = 1.0
    return np.angle(np.linalg.eigvals(companion))


def _symmetric(potential: TrigonometricPotential) -> Quad:
    """Critical points for b = 0, where sin(theta) (c - 2 a cos(theta)) = 0: at a pitchfork Newton's
    method would meet a triple root."""
    a, c = potential.a, potential.c
    tilt = np.arctan2(np.sqrt(4 * a * a - c * c), np.where(a > 0, c, -c))
    return np.concatenate([0 * c, 0 * c + PI, tilt, -tilt], axis=-1)
