"""The picture of a mechanism in a replay: the direction of view, the extent, and its solids."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.drawn_mechanism import DrawnMechanism, Solid, frames
from plumbob.reports.records.page_records import ReplayView

PictureBox = tuple[float, float, float, float]  # left, right, bottom, top
# direction of an oblique view: beside the normal to the main motion, and above the horizontal
AZIMUTH = math.radians(25.0)
PICTURE_ELEVATION = math.radians(20.0)
# largest extent of a motion across a plane, or across a line, relative to the extent along it
FLAT = 0.02
# smallest ratio of a mechanism's height to its extent at which it hides its motion from above
HIDING_HEIGHT = 0.5
# most times at which the motion is looked at to choose the view and its extent
MOST_VIEWED = 201
# margins relative to the diagonal: around the motion, of a floor around it, and for the ruler
MOTION_MARGIN, FLOOR_MARGIN, RULER_MARGIN = 0.04, 0.12, 0.05
LEAST_ASPECT = 0.3  # smallest ratio of the height of a picture to its width
ALONG_AXES = np.concatenate([np.eye(3), -np.eye(3)])
POINT_DIGITS = 4  # digits of the points of solids after the first one of the picture's size
# smallest ratio of the displacement of a point that bears the mark to the largest
LEAST_MARKED = 0.5
UNPAINTED = 0.5  # red, green and blue of a geom without a colour of its own


@dataclass(frozen=True)
class Picture:
    """The picture of a mechanism and of its exact coordinates at n times, shape (n, k)."""

    mechanism: DrawnMechanism
    coordinates: Array

    @cached_property
    def moving(self) -> tuple[Solid, ...]:
        """The solids of bodies that move."""
        return tuple(solid for solid in self.mechanism.solids if solid.body)

    def corners(self, coordinates: Array) -> Array:
        """Returns the corner points of the moving solids [m], shape (m, corners, 3), at
        coordinates, shape (m, k). A round solid has corners at its radius along its axes."""
        at = frames(self.mechanism, coordinates)
        return np.concatenate([at.placed(s.body, _corners(s)) for s in self.moving], axis=1)

    def errors(self, coordinates: Array, changes: Array) -> Array:
        """Returns the largest displacement of a corner point [m], shape (m,), by changes of
        coordinates, shape (m, k)."""
        moved = self.corners(coordinates + changes) - self.corners(coordinates)
        return np.asarray(np.linalg.norm(moved, axis=2).max(axis=1))

    @cached_property
    def path(self) -> Array:
        """The corner points at some times of the exact motion, shape (times, corners, 3)."""
        last = len(self.coordinates) - 1
        viewed = np.unique(np.linspace(0, last, min(last + 1, MOST_VIEWED)).astype(int))
        return self.corners(self.coordinates[viewed])

    def lively_part(self, sizes: float) -> float:
        """Returns the fraction of the motion's duration in which the fastest corner point moves by
        so many sizes of the picture; at most 1."""
        steps = np.linalg.norm(np.diff(self.path, axis=0), axis=2).max(axis=1)
        fast = np.cumsum(steps) > sizes * self.size
        return float(np.argmax(fast) + 1) / len(steps) if fast.any() else 1.0

    @cached_property
    def view(self) -> tuple[ReplayView, Array]:
        """The kind of view, and the world's directions to the right, upwards and towards the
        viewer, as rows, shape (3, 3)."""
        up = self.mechanism.up
        moved = (self.path - self.path[0]).reshape(-1, 3)
        _, extents, directions = np.linalg.svd(moved, full_matrices=False)
        longest, middle, shortest = extents
        normal = directions[2]
        level = abs(normal @ up) > 1.0 - FLAT
        tall = np.ptp(self.path @ up) > HIDING_HEIGHT * np.ptp(self.path, axis=(0, 1)).max()
        if shortest <= FLAT * longest < middle and not (level and tall):
            if level:
                return "above", _camera(np.cross(up, [1.0, 0.0, 0.0]), up)
            return "plane", _camera(up, normal)
        along = directions[0] - (directions[0] @ up) * up
        if not longest or np.linalg.norm(along) < FLAT:
            along = np.array([1.0, 0.0, 0.0])
        across = np.cross(along, up)
        across /= np.linalg.norm(across)
        across *= np.sign(np.cross(up, across).sum()) or 1.0
        aside = math.cos(AZIMUTH) * across + math.sin(AZIMUTH) * np.cross(up, across)
        towards = math.cos(PICTURE_ELEVATION) * aside + math.sin(PICTURE_ELEVATION) * up
        return "oblique", _camera(up, towards)

    @cached_property
    def size(self) -> float:
        """The diagonal of the motion in the picture [m]."""
        seen = self.path @ self.view[1][:2].T
        return float(np.hypot(*np.ptp(seen, axis=(0, 1)))) or 1.0

    @cached_property
    def floors(self) -> tuple[Array, ...]:
        """The corners of the part of each floor that is drawn [m], shape (4, 3) each: below the
        whole motion, with a margin."""
        drawn = []
        for solid in self.mechanism.solids:
            if solid.floor and not solid.body:
                origin = solid.points[0]
                axes = solid.points[1:] - origin
                places = ((self.path - origin) @ axes.T).reshape(-1, 2)
                low = places.min(axis=0) - FLOOR_MARGIN * self.size
                high = places.max(axis=0) + FLOOR_MARGIN * self.size
                ends = [low, (high[0], low[1]), high, (low[0], high[1])]
                drawn.append(origin + np.array(ends) @ axes)
        return tuple(drawn)

    @cached_property
    def box(self) -> PictureBox:
        """The extent of the picture [m]: the whole motion, and the points of floors and of fixed
        solids near it."""
        camera = self.view[1][:2]
        seen = [(self.path @ camera.T).reshape(-1, 2)]
        fixed = [_corners(s) for s in self.mechanism.solids if not s.body and not s.floor]
        low = self.path.min(axis=(0, 1)) - self.size
        high = self.path.max(axis=(0, 1)) + self.size
        for points in (*self.floors, *fixed):
            near = ((low <= points) & (points <= high)).all(axis=1)
            seen.append(points[near] @ camera.T)
        places = np.concatenate(seen)
        pad = MOTION_MARGIN * self.size
        left, bottom = (places.min(axis=0) - pad).tolist()
        right, top = (places.max(axis=0) + pad).tolist()
        bottom -= RULER_MARGIN * (right - left)
        lacking = max(LEAST_ASPECT * (right - left) - (top - bottom), 0.0) / 2.0
        return left, right, bottom - lacking, top + lacking

    def mark(self, changes: Array) -> tuple[int, list[float]]:
        """Returns the body that bears the mark, and the place of the mark in its frame: the first
        point that is displaced by at least half as much as any, of the bodies' centres of mass and
        then of their corners. `changes` are displaced coordinates, less the exact ones."""
        bodies = sorted({solid.body for solid in self.moving})
        points = [(body, self.mechanism.bodies[body].centre) for body in bodies]
        points += [(solid.body, corner) for solid in self.moving for corner in _corners(solid)]
        before, after = (
            frames(self.mechanism, at) for at in (self.coordinates, self.coordinates + changes)
        )
        moved = [
            np.linalg.norm(after.placed(b, p[None]) - before.placed(b, p[None]), axis=2).max()
            for b, p in points
        ]
        body, point = points[int(np.argmax(np.array(moved) >= LEAST_MARKED * max(moved)))]
        return body, point.tolist()

    def geometry(self) -> dict[str, Any]:
        """Returns the values of the picture for the page's script."""
        digits = POINT_DIGITS - math.floor(math.log10(self.size))
        floors = [{"body": 0, "floor": True, "points": f} for f in self.floors]
        others = [s for s in self.mechanism.solids if s.body or not s.floor]
        solids = [*floors, *map(_drawn_solid, others)]
        return {
            "camera": np.round(self.view[1], 6),
            "box": self.box,
            "size": self.size,
            "bodies": list(map(asdict, self.mechanism.bodies[1:])),
            "solids": [{**s, "points": np.round(s["points"], digits)} for s in solids],
        }


def _camera(up: Array, towards: Array) -> Array:
    """Returns the directions to the right, upwards and towards the viewer, as rows. The view is
    along `towards`, from the side on which the world's x and y point to the right."""
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    if right.sum() < 0.0:
        right, towards = -right, -towards
    return np.array([right, np.cross(towards, right), towards])


def _corners(solid: Solid) -> Array:
    """Returns the corner points of a solid in the frame of its body [m], shape (n, 3)."""
    if not solid.radius:
        return solid.points
    return (solid.points[:, None] + solid.radius * ALONG_AXES).reshape(-1, 3)


def _drawn_solid(solid: Solid) -> dict[str, Any]:
    """Returns the values of a solid for the page's script. A solid with flat faces has them as
    numbers of its points, each seen counterclockwise from outside."""
    # Bodies that a file leaves unpainted have two shades.
    shade = 1.0 + 0.3 * (solid.body % 2) if set(solid.colour) == {UNPAINTED} else 1.0
    drawn: dict[str, Any] = {
        "body": solid.body,
        "points": solid.points,
        "radius": solid.radius,
        "colour": [round(255 * value * shade) for value in solid.colour],
    }
    if not solid.radius:
        drawn |= dict(zip(("points", "faces"), _hull(solid.points), strict=True))
    return drawn


def _hull(points: Array) -> tuple[Array, list[list[int]]]:
    """Returns the corners of the convex hull of points, shape (n, 3), and its faces; all points and
    no faces if they lie in a plane."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return points, []
    kept: list[int] = list(hull.vertices)
    corners = points[kept]
    flat: dict[tuple[float, ...], set[int]] = {}
    size = float(np.ptp(points, axis=0).max())
    triangles: list[list[int]] = hull.simplices.tolist()
    for equation, triangle in zip(hull.equations, triangles, strict=True):
        normal = tuple(np.round([*equation[:3], equation[3] / size], 4).tolist())
        flat.setdefault(normal, set()).update(kept.index(corner) for corner in triangle)
    faces = (_around(corners, sorted(face), normal) for normal, face in flat.items())
    return corners, list(faces)


def _around(corners: Array, face: Sequence[int], normal: Sequence[float]) -> list[int]:
    """Returns the corners of a face in the order in which they are seen from outside."""
    outwards = np.array(normal[:3])
    places = corners[face] - corners[face].mean(axis=0)
    first = places[0]
    angles = np.arctan2(places @ np.cross(outwards, first), places @ first)
    return [face[place] for place in np.argsort(angles).tolist()]
