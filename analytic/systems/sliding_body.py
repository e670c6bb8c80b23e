"""A rigid body that slides on points of a horizontal plane without turning, and stops.

Under Coulomb friction every point that slides along the unit vector e has the force -f N_i e, so
the resultant is -f W e for every distribution of the loads N_i. The loads balance its moment f W h
about the horizontal, sum(N_i r_i) = f W h e (r_i from the centre of mass, which is at a height h).
So the moment about the vertical, -f sum(N_i r_i) x e, is zero: the body does not turn. That
requires loads N_i >= 0, which exist if the point f h e is in the convex hull of the r_i.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array


@dataclass(frozen=True)
class Stance:
    """Points of support, shape (n, 2), relative to the centre of mass, and its height,
    all in [m]."""

    points: Array
    height: float

    def inside(self, place: Array) -> float:
        """Returns the distance [m] from `place`, shape (2,), to the edge of the convex hull of the
        points: positive inside, negative outside, minus infinity if the points are on one line.

        >>> square = Stance(np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]]), 0.5)
        >>> square.inside(np.array([0.25, 0.0])), square.inside(np.array([2.0, 0.0]))
        (0.75, -1.0)
        """
        from scipy.spatial import ConvexHull, QhullError

        try:
            hull = ConvexHull(np.asarray(self.points, dtype=float))
        except (QhullError, ValueError):  # fewer than three points, or points on one line
            return -np.inf
        return -float((hull.equations[:, :2] @ place + hull.equations[:, 2]).max())

    def slides(self, friction: float, heading: float) -> bool:
        """Returns True if every load can stay >= 0 while the body slides along `heading` [rad]."""
        pressure_centre = friction * self.height * np.array([np.cos(heading), np.sin(heading)])
        return self.inside(pressure_centre) >= 0.0

    def tilt(self, heading: float) -> float:
        """Returns the displacement of the centre of mass along `heading` [rad] by the tilt on
        elastic contacts under a force at the centre in that direction. Its unit is the deflection
        of one contact under that force: h^2 e K^-1 e, K = sum(b_i b_i) with the points b_i measured
        from their mean.

        >>> Stance(np.array([[2, 1], [2, -1], [-2, 1], [-2, -1]]), 2.0).tilt(0.0)
        0.25
        """
        arms = self.points - self.points.mean(axis=0)
        direction = np.array([np.cos(heading), np.sin(heading)])
        stiffness = arms.T @ arms
        return float(self.height**2 * direction @ np.linalg.solve(stiffness, direction))


def stopping_distance(speed: float, friction: float, gravity: float) -> float:
    """Returns v^2/(2 f g) [m], the distance in which a body that slides without turning stops.

    >>> stopping_distance(0.5, 0.3, 9.81)
    0.04247366632687734
    """
    return speed**2 / (2.0 * friction * gravity)
