"""The potential V = -a sin^2(theta) - b sin(theta) - c cos(theta): values and critical points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from plumbob.analytic.numerics.quad import PI, Quad, choose, double, quad
from plumbob.analytic.reference import Array

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
        twice = (self.a + self.a) * sine + self.b
        slope = self.c * sine - twice * cosine
        return slope, twice * sine + (self.c - (self.a + self.a) * cosine) * cosine

    @property
    def scale(self) -> Any:
        """|a| + |b| + |c| [J], in double."""
        return double(abs(self.a) + abs(self.b) + abs(self.c))


def critical_points(potential: TrigonometricPotential) -> Quad:
    """Angles in (-pi, pi] where dV/dtheta = 0, in 34 digits, ascending but for places
    without one, which hold NaN, shape (..., 4)."""
    coefficients = (potential.a, potential.b, potential.c)
    exact = TrigonometricPotential(*(x[..., None] if np.ndim(x) else x for x in coefficients))
    a, b, c = (np.asarray(double(x))[..., None] for x in coefficients)
    rough, scale = TrigonometricPotential(a, b, c), np.abs(a) + np.abs(b) + np.abs(c)
    with np.errstate(all="ignore"):
        fine = _polished(exact, quad(np.sort(_approximate(rough), axis=-1)))
        if (level := b == 0.0).any():
            fine = np.where(level, _symmetric(potential), fine)
        close = double(fine)
        # A false root has a slope that is not zero, a repeated one a neighbour at no distance.
        none = ~(np.abs(rough.slope(close)) <= 1e-12 * scale) | (scale == 0.0)
        none[..., 1:] |= close[..., 1:] - close[..., :-1] < 1e-12
        if none.any():
            fine = np.where(none, quad(np.nan), fine)
        if (outside := np.abs(close) > np.pi).any():
            fine = np.where(outside, fine - 2 * PI * quad(np.rint(close / (2 * np.pi))), fine)
    return fine


def finite_points(potential: TrigonometricPotential) -> Quad:
    """Those of one potential alone, shape (n,)."""
    points = critical_points(potential)
    return points[np.isfinite(double(points))]


def kind(potential: TrigonometricPotential, theta: Quad) -> Kind:
    """Kind of the equilibrium at a critical point `theta`, a scalar."""
    curvature = double(potential.curvature(theta))
    # At a pitchfork the curvature is zero but for rounding of the coefficients.
    if abs(curvature) <= 4e-16 * potential.scale:
        return "degenerate"
    return "centre" if curvature > 0.0 else "saddle"


def _polished(potential: TrigonometricPotential, theta: Quad) -> Quad:
    """Newton's method on dV/dtheta until the error after a step is below round-off."""
    for _ in range(40):
        slope, curvature = potential.slope_and_curvature(theta)
        step = slope / np.where(curvature == 0.0, quad(1.0), curvature)
        theta = theta - step
        if not (np.abs(double(step)) > 1e-14).any():
            break
    return theta


def _approximate(potential: TrigonometricPotential) -> Array:
    """Starting angles or NaN, shape (..., 4): arguments of the roots of dV/dtheta in
    z = e^(i theta), -a z^4 + (c - ib) z^3 - (c + ib) z + a = 0, as eigenvalues of companion
    matrices."""
    a, b, c = (x[..., 0] for x in (potential.a, potential.b, potential.c))
    tiny = 1e-8 * (np.abs(b) + np.abs(c))
    lead = np.where(np.abs(a) > tiny, a, tiny + (tiny == 0.0))  # Newton's method removes the change
    companion = np.zeros((*a.shape, 4, 4), dtype=complex)
    companion[..., 1, 0] = companion[..., 2, 1] = companion[..., 3, 2] = 1.0
    companion[..., 0, 0] = (c - 1j * b) / lead
    companion[..., 0, 2] = -(c + 1j * b) / lead
    companion[..., 0, 3] = 1.0
    roots = np.linalg.eigvals(companion)
    return np.where(np.abs(np.abs(roots) - 1.0) < 1e-4, np.angle(roots), np.nan)


def _symmetric(potential: TrigonometricPotential) -> Quad:
    """Critical points for b = 0, where sin(theta) (c - 2 a cos(theta)) = 0: at a pitchfork Newton's
    method would meet a triple root."""
    a, c = potential.a, potential.c
    tilt = np.arctan2(np.sqrt(4 * a * a - c * c), choose(a > 0, c, -c))
    return np.stack(np.broadcast_arrays(-tilt, 0 * c, tilt, 0 * c + PI), axis=-1)
