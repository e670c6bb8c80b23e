"""The potential V = -a sin^2(theta) - b sin(theta) - c cos(theta): values and critical points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from plumbob.analytic.numerics.quad import PI, Quad, double, quad
from plumbob.analytic.reference import Array

EquilibriumKind = Literal["centre", "saddle", "degenerate"]


@dataclass(frozen=True)
class TrigonometricPotential:
    """The potential of Sudakov 2015, eq. 7, with coefficients a, b, c [J] in any arithmetic, of one
    shape."""

    a: Any
    b: Any
    c: Any

    def value(self, theta: Any) -> Any:
        """Returns the potential V(theta) [J]."""
        sine = np.sin(theta)
        cosine = np.cos(theta)
        return -(self.a * sine + self.b) * sine - self.c * cosine

    def slope(self, theta: Any) -> Any:
        """Returns dV/dtheta [J/rad]."""
        return self.slope_and_curvature(theta)[0]

    def curvature(self, theta: Any) -> Any:
        """Returns d^2V/dtheta^2 [J/rad^2]."""
        return self.slope_and_curvature(theta)[1]

    def slope_and_curvature(self, theta: Any) -> tuple[Any, Any]:
        """Returns dV/dtheta [J/rad] and d^2V/dtheta^2 [J/rad^2] from one sine and one cosine."""
        sine = np.sin(theta)
        cosine = np.cos(theta)
        twice = (self.a + self.a) * sine + self.b
        slope = self.c * sine - twice * cosine
        return slope, twice * sine + (self.c - (self.a + self.a) * cosine) * cosine

    @property
    def scale(self) -> Any:
        """Sum |a| + |b| + |c| [J], in double."""
        return double(abs(self.a) + abs(self.b) + abs(self.c))


def critical_points(potential: TrigonometricPotential) -> Quad:
    """Returns the angles in (-pi, pi] with dV/dtheta = 0, in 34 digits, ascending, shape (n,), of
    one potential."""
    coefficients = double(potential.a), double(potential.b), double(potential.c)
    in_doubles = TrigonometricPotential(*coefficients)
    scale = sum(map(abs, coefficients))
    if not scale:
        return quad(np.zeros(0))
    with np.errstate(all="ignore"):
        if in_doubles.b:
            angles = _newton_angles(potential, quad(_approximate_angles(in_doubles)))
        else:
            angles = _symmetric_angles(potential)
        rounded = double(angles)
        # A false root has a slope that is not zero. A repeated root is equal to its neighbour.
        valid = np.abs(in_doubles.slope(rounded)) <= 1e-12 * scale
        valid[1:] &= ~(np.diff(rounded) < 1e-12)
        turns = quad(np.rint(rounded / (2 * np.pi)))
        return (angles - 2 * PI * turns)[valid]


def crests(potential: TrigonometricPotential) -> Quad:
    """Returns the angles of the maxima of one potential, in 34 digits, highest first."""
    points = critical_points(potential)
    tops = points[double(potential.curvature(points)) < 0.0]
    return tops[np.argsort(-double(potential.value(tops)), kind="stable")]


def equilibrium_kind(potential: TrigonometricPotential, theta: Quad) -> EquilibriumKind:
    """Returns the kind of the equilibrium at a critical point `theta`, a scalar."""
    curvature = double(potential.curvature(theta))
    # At a pitchfork the curvature is zero but for rounding of the coefficients.
    if abs(curvature) <= 4e-16 * potential.scale:
        return "degenerate"
    return "centre" if curvature > 0.0 else "saddle"


def _newton_angles(potential: TrigonometricPotential, theta: Quad) -> Quad:
    """Returns angles improved by Newton's method on dV/dtheta, until the error is below
    round-off."""
    for _ in range(40):
        slope, curvature = potential.slope_and_curvature(theta)
        step = slope / np.where(curvature == 0.0, quad(1.0), curvature)
        theta = theta - step
        if not (np.abs(double(step)) > 1e-14).any():
            break
    return theta


def _approximate_angles(potential: TrigonometricPotential) -> Array:
    """Returns approximate angles of the critical points, ascending.

    In z = e^(i theta), dV/dtheta = 0 is the equation a z^4 - (c - ib) z^3 + (c + ib) z - a = 0,
    where a, b and c are the coefficients of `potential`. The angles are the arguments of its roots
    on the unit circle.
    """
    a = potential.a
    b = potential.b
    c = potential.c
    tiny = 1e-8 * (abs(b) + abs(c))
    # The first coefficient must not be zero. Newton's method corrects this change of `a` later.
    nonzero_a = a if abs(a) > tiny else tiny
    roots = np.roots([nonzero_a, 1j * b - c, 0.0, c + 1j * b, -nonzero_a])
    on_circle = np.abs(np.abs(roots) - 1.0) < 1e-4
    return np.sort(np.angle(roots[on_circle]))


def _symmetric_angles(potential: TrigonometricPotential) -> Quad:
    """Returns the critical points for b = 0, the solutions of sin(theta) (c - 2 a cos(theta)) = 0.

    A point that does not exist is NaN. A closed form is needed because at a pitchfork Newton's
    method would meet a triple root.
    """
    a = quad(potential.a)
    c = quad(potential.c)
    tilt = np.arctan2(np.sqrt(4 * a * a - c * c), c if a > 0 else -c)
    return np.array([-tilt, 0 * c, tilt, 0 * c + PI])
