"""A rigid body that slides on points of a horizontal plane without turning, and stops.

Under Coulomb friction every point that slides along the unit vector e takes -f N_i e, so that the
resultant is -f W e however the load is distributed over the N_i. The loads balance its moment f W h
about the horizontal, sum(N_i r_i) = f W h e (r_i from the centre of mass, which is at a height h),
and so the moment about the vertical, -f sum(N_i r_i) x e, is zero: the body does not turn. That
requires loads N_i >= 0, which exist where the point f h e is in the convex hull of the r_i.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array


@dataclass(frozen=True)
class Stance:
    """Points of support, shape (n, 2), relative to the centre of mass, and its height [m]."""

    points: Array
    height: float

    def inside(self, place: Array) -> float:
        """How far [m] the place, shape (2,), is inside the convex hull of the points; negative
        outside, minus infinity where they are on one line.

        >>> square = Stance(np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]]), 0.5)
        >>> square.inside(np.array([0.25, 0.0])), square.inside(np.array([2.0, 0.0]))
        (0.75, -1.0)
        """
        from scipy.spatial import ConvexHull, QhullError

        try:
            hull = ConvexHull(np.asarray(self.points, dtype=float))
        except (QhullError, ValueError):  # fewer than three, or on one line
            return -np.inf
        return -float((hull.equations[:, :2] @ place + hull.equations[:, 2]).max())

    def slides(self, friction: float, heading: float) -> bool:
        """Whether every load can stay >= 0 while it slides along `heading` [rad]."""
        ahead = friction * self.height * np.array([np.cos(heading), np.sin(heading)])
        return self.inside(ahead) >= 0.0

    def tilt(self, heading: float) -> float:
        """By how much a tilt on elastic contacts moves the centre of mass along `heading` [rad]
        under a force there, in multiples of a contact's deflection under that force: h^2 e K^-1 e,
        K = sum(b_i b_i) of the points measured from their mean.

        >>> Stance(np.array([[2, 1], [2, -1], [-2, 1], [-2, -1]]), 2.0).tilt(0.0)
        0.25
        """
        arms = self.points - self.points.mean(axis=0)
        way = np.array([np.cos(heading), np.sin(heading)])
        return float(self.height**2 * way @ np.linalg.solve(arms.T @ arms, way))


def stopping_distance(speed: float, friction: float, gravity: float) -> float:
    """v^2/(2 f g) [m] of a body that slides without turning.

    >>> stopping_distance(0.5, 0.3, 9.81)
    0.04247366632687734
    """
    return speed**2 / (2.0 * friction * gravity)
