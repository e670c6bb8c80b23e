"""Pairs of geoms that MuJoCo lets collide, and the distance at which each pair begins to touch."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array

BITS = mujoco.mjtDisableBit
KIND = mujoco.mjtGeom
NO_CONTACTS = int(BITS.mjDSBL_CONTACT | BITS.mjDSBL_CONSTRAINT)
OVERRIDE = int(mujoco.mjtEnableBit.mjENBL_OVERRIDE)
# kinds of geoms that are not convex, whose distance mj_geomDistance does not bound
UNMEASURED = MappingProxyType(
    {int(KIND.mjGEOM_HFIELD): "height fields", int(KIND.mjGEOM_SDF): "signed distance fields"}
)
UNBOUNDED = (int(KIND.mjGEOM_PLANE), int(KIND.mjGEOM_HFIELD))  # MuJoCo tests no pair of these


def colliding_pairs(model: Any) -> tuple[Array, Array]:
    """The pairs of geoms that MuJoCo tests for contacts and whose distance can be measured, shape
    (n, 2), and their margins [m], shape (n,): two geoms touch if their distance is less than the
    margin."""
    pairs, margins = _pairs(model)
    measured = ~np.isin(model.geom_type[pairs], list(UNMEASURED)).any(axis=1)
    return pairs[measured], margins[measured]


def unmeasured(model: Any) -> tuple[str, ...]:
    """The kinds of shapes of `model` that can collide but whose distance cannot be measured."""
    pairs, _ = _pairs(model)
    kinds = np.unique(model.geom_type[pairs]).tolist()
    names = tuple(name for kind, name in UNMEASURED.items() if kind in kinds)
    flexes = (model.flex_contype | model.flex_conaffinity).any()
    return (*names, "flexes") if flexes and not model.opt.disableflags & NO_CONTACTS else names


def _pairs(model: Any) -> tuple[Array, Array]:
    """All pairs of geoms that MuJoCo tests for contacts, shape (n, 2), and their margins [m], shape
    (n,). A margin is the sum of the two geoms' margins. A pair that the file lists has its own
    margin, and MuJoCo's filters do not apply to it."""
    listed = np.sort(np.stack([model.pair_geom1, model.pair_geom2], axis=1), axis=1)
    first, second = np.triu_indices(model.ngeom, 1)
    tested = _unfiltered(model, first, second)
    tested &= ~np.isin(_key(model, first, second), _key(model, *listed.T))
    unlisted = np.stack([first[tested], second[tested]], axis=1)
    pairs = np.concatenate([unlisted, listed])
    margins = np.concatenate([model.geom_margin[unlisted].sum(1), model.pair_margin])
    if model.opt.enableflags & OVERRIDE:
        margins = np.full(len(pairs), model.opt.o_margin)
    can_touch = ~np.isin(model.geom_type[pairs], UNBOUNDED).all(axis=1)
    can_touch &= not model.opt.disableflags & NO_CONTACTS
    return pairs[can_touch], margins[can_touch]


def _key(model: Any, first: Any, second: Any) -> Any:
    """A different number for each pair of geoms, by which pairs are compared."""
    return first * model.ngeom + second


def _unfiltered(model: Any, first: Any, second: Any) -> Any:
    """Whether each pair of geoms passes MuJoCo's filters:

    - the bits of the geoms match, and the file does not exclude their bodies;
    - at least one body can move, and the bodies are not welded to each other (a mocap body counts
      as fixed);
    - neither body is the parent of the other, unless the parent is the world.
    """
    bits = model.geom_contype[first] & model.geom_conaffinity[second]
    bits |= model.geom_contype[second] & model.geom_conaffinity[first]
    bodies = np.sort(np.stack([model.geom_bodyid[first], model.geom_bodyid[second]]), axis=0)
    welds = model.body_weldid[bodies]
    parents = model.body_weldid[model.body_parentid[welds]]
    parental = (welds[0] == parents[1]) | (welds[1] == parents[0])
    if model.opt.disableflags & int(BITS.mjDSBL_FILTERPARENT):
        parental[:] = False
    excluded = np.isin((bodies[0] << 16) + bodies[1], model.exclude_signature)
    still = (model.body_treeid[bodies] < 0).all(axis=0)
    filtered = (welds[0] == welds[1]) | (parental & welds.all(axis=0)) | excluded | still
    return (bits != 0) & ~filtered
