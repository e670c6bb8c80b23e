"""The geoms of a model as convex solids of its bodies, for replays."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.drawn_mechanism import Solid

KIND = mujoco.mjtGeom
CORNERS = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
SHOWN = 3  # number of groups of geoms that MuJoCo draws by default
RIM = 24  # points on the rim of a cylinder and on the equator of a sphere


def solids(model: Any, data: Any) -> Iterator[Solid]:
    """Yields the solids of the compiled `model` at `data`: the drawn geoms of each body, or all its
    geoms if none is drawn, and every plane. The geoms of a body that is fixed to the world belong
    to the world."""
    planes = model.geom_type == KIND.mjGEOM_PLANE
    drawn = (model.geom_group < SHOWN) & (model.geom_rgba[:, 3] > 0.0)
    drawn_bodies = model.geom_bodyid[drawn & ~planes]
    of_undrawn_body = ~np.isin(model.geom_bodyid, drawn_bodies)
    for geom in np.flatnonzero(drawn | of_undrawn_body | planes).tolist():
        points, radius = _shape(model, geom)
        placed = points @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
        body = int(model.geom_bodyid[geom])
        if model.body_weldid[body]:
            # into the body's frame
            placed = (placed - data.xpos[body]) @ data.xmat[body].reshape(3, 3)
        else:
            body = 0  # fixed to the world
        yield Solid(body, placed, radius, _colour(model, geom), bool(planes[geom]))


def mesh_vertices(model: Any, geom: int) -> Array:
    """Returns the vertices of the mesh of a geom in the geom's frame [m], shape (n, 3)."""
    mesh = model.geom_dataid[geom]
    first = model.mesh_vertadr[mesh]
    return np.array(model.mesh_vert[first : first + model.mesh_vertnum[mesh]], float)


def _colour(model: Any, geom: int) -> tuple[float, float, float]:
    """Returns the red, green and blue part of a geom's colour, or of its material's."""
    material = model.geom_matid[geom]
    rgba = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
    red, green, blue, _ = rgba.tolist()
    return red, green, blue


def _shape(model: Any, geom: int) -> tuple[Array, float]:
    """Returns points of a geom in its own frame [m], shape (n, 3), and the radius [m] that thickens
    their hull. A mesh has its outermost points. A geom of another kind is a box."""
    kind = model.geom_type[geom]
    size = model.geom_size[geom]
    if kind == KIND.mjGEOM_SPHERE:
        return np.zeros((1, 3)), float(size[0])
    if kind == KIND.mjGEOM_CAPSULE:
        return np.outer([-size[1], size[1]], [0.0, 0.0, 1.0]), float(size[0])
    if kind == KIND.mjGEOM_PLANE:
        return np.eye(3)[[2, 0, 1]] * [1.0, 1.0, 0.0], 0.0
    if kind == KIND.mjGEOM_CYLINDER:
        return np.concatenate([_ring(size[0], height) for height in (-size[1], size[1])]), 0.0
    if kind == KIND.mjGEOM_ELLIPSOID:
        return _sphere() * size, 0.0
    if kind == KIND.mjGEOM_MESH:
        vertices = mesh_vertices(model, geom)
        furthest = (vertices @ _sphere().T).argmax(axis=0)
        return vertices[np.unique(furthest)], 0.0
    box = model.geom_aabb[geom]
    return box[:3] + CORNERS * box[3:], 0.0


def _ring(radius: float, height: float) -> Array:
    """Returns points on a circle about z [m], shape (RIM, 3)."""
    angles = np.linspace(0.0, 2.0 * math.pi, RIM, endpoint=False)
    circle = [radius * np.cos(angles), radius * np.sin(angles), np.full(RIM, height)]
    return np.stack(circle, axis=1)


def _sphere() -> Array:
    """Returns points on the sphere of radius 1 in rings about z, shape (n, 3)."""
    tilts = np.linspace(0.0, math.pi, RIM // 4 + 1)
    return np.concatenate([_ring(math.sin(tilt), math.cos(tilt)) for tilt in tilts])
