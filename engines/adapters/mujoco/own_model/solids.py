"""The geoms of a model as convex solids about the bodies' centres of mass, for its replay."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.own_motion import Solid

KIND = mujoco.mjtGeom
CORNERS = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
SHOWN = 3  # number of groups of geoms that MuJoCo draws by default
FLOOR = 2.0  # largest half side of a plane, in extents of the model


def solids(model: Any, data: Any) -> Iterator[Solid]:
    """Yields the solids of the compiled `model` at `data`: the drawn geoms of each body, or all its
    geoms if none is drawn. The geoms of a body that is fixed to the world belong to the world."""
    drawn = (model.geom_group < SHOWN) & (model.geom_rgba[:, 3] > 0.0)
    bare = ~np.isin(model.geom_bodyid, model.geom_bodyid[drawn])
    for geom in np.flatnonzero(drawn | bare).tolist():
        points, radius = _shape(model, geom)
        placed = points @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
        body = model.geom_bodyid[geom]
        if not model.body_weldid[body]:
            yield Solid(0, placed, radius)
            continue
        turn = data.xmat[body].reshape(3, 3)
        yield Solid(int(body), (placed - data.xipos[body]) @ turn, radius)


def _shape(model: Any, geom: int) -> tuple[Array, float]:
    """Returns points of a geom in its own frame [m], shape (n, 3), and the radius [m] that thickens
    their hull. A geom that is neither round nor a mesh is a box."""
    kind = model.geom_type[geom]
    size = model.geom_size[geom]
    if kind in (KIND.mjGEOM_SPHERE, KIND.mjGEOM_CAPSULE):  # a sphere has no length
        return np.outer([-size[1], size[1]], [0.0, 0.0, 1.0]), float(size[0])
    if kind == KIND.mjGEOM_PLANE:
        most = FLOOR * model.stat.extent
        sides = np.minimum(most, np.where(size[:2] > 0.0, size[:2], most))
        return CORNERS[[0, 2, 6, 4]] * (*sides, 0.0), 0.0
    if kind == KIND.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first = model.mesh_vertadr[mesh]
        places = model.mesh_vert[first : first + model.mesh_vertnum[mesh]]
        furthest = (
            (places @ CORNERS.T).argmax(axis=0),
            places.argmin(axis=0),
            places.argmax(axis=0),
        )
        return np.array(places[np.unique(np.concatenate(furthest))], float), 0.0
    box = model.geom_aabb[geom]
    return box[:3] + CORNERS * box[3:], 0.0
