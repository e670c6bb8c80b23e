"""The corner points of a model's bodies. Their displacements are the errors that an audit
measures."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.solids import CORNERS

# The box around a plane is infinite, but MuJoCo lets no plane move.
PLANE = mujoco.mjtGeom.mjGEOM_PLANE
ORIGIN = np.zeros((1, 3))


def corners_of(model: Any) -> tuple[Array, Array]:
    """Returns corner points of all bodies in their own frames [m], shape (corners, 3), and the body
    of each, shape (corners,)."""
    points = [_corners(model, body) for body in range(model.nbody)]
    bodies = np.repeat(np.arange(model.nbody), [len(of_body) for of_body in points])
    return np.concatenate(points), bodies


def _corners(model: Any, body: int) -> Array:
    """Returns corner points of a body in its frame [m], shape (n, 3): those of the boxes around its
    geoms, including geoms that are only drawn. A body without geoms has the corners of the box with
    its mass and inertia. A body without either, or a body that cannot move, has the origin of its
    frame."""
    if not model.body_weldid[body]:
        return ORIGIN
    geoms = np.flatnonzero((model.geom_bodyid == body) & (model.geom_type != PLANE))
    boxes = [
        _box_corners(model.geom_pos[geom], model.geom_quat[geom], model.geom_aabb[geom])
        for geom in geoms.tolist()
    ]
    if not boxes and model.body_mass[body] > 0.0:
        moments = model.body_inertia[body]
        squares = 1.5 * (moments.sum() - 2.0 * moments) / model.body_mass[body]
        box = [0.0, 0.0, 0.0, *np.sqrt(np.maximum(squares, 0.0))]
        boxes = [_box_corners(model.body_ipos[body], model.body_iquat[body], box)]
    return _outermost(np.unique(np.concatenate(boxes), axis=0)) if boxes else ORIGIN


def _box_corners(place: Array, attitude: Array, box: Any) -> Array:
    """Returns the eight corners [m] of a `box`, shape (8, 3), in the frame in which the box's own
    frame has a `place` [m] and an `attitude` (a quaternion). `box` is its middle and half its sides
    [m]."""
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, attitude)
    return np.asarray((box[:3] + CORNERS * box[3:]) @ turn.reshape(3, 3).T + place)


def _outermost(points: Array) -> Array:
    """Returns the vertices of the convex hull of `points`: any rigid motion moves one of the
    vertices furthest. If the points span no volume, all of them are returned."""
    from scipy.spatial import ConvexHull, QhullError

    if len(points) <= len(CORNERS):
        return points
    try:
        return points[np.sort(ConvexHull(points).vertices)]
    except QhullError:
        return points
