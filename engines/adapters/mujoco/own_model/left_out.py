"""Features that a MuJoCo model can omit on a motion: collisions, stages, iterations."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any

import mujoco
import numpy as np

from plumbob.engines.adapters.mujoco.options import needless_stages
from plumbob.engines.own_motion import Change

BITS = mujoco.mjtDisableBit
FEW = 5  # solver iterations to try
LOOSE = 1e-5  # solver tolerance to try, if the model's is smaller
NEVER = -1e6  # [m] margin at which a pair never touches
STAGES = ("ISLAND", "WARMSTART", "MIDPHASE")  # stages of any model, which a motion may not need


def removable_features(model: Any, met: set[tuple[int, ...]]) -> Iterator[Change]:
    """Yields features that may be removed from `model`. The pairs of geoms `met`, smaller number
    first, are all pairs that touched."""
    collides = (model.geom_contype | model.geom_conaffinity) != 0
    yield from _never_touching(model, collides, met)
    disabled = int(model.opt.disableflags)
    idle = needless_stages(model)
    constrained = not idle & BITS.mjDSBL_CONSTRAINT
    sensors = int(BITS.mjDSBL_SENSOR)
    stages = {
        "sensors": sensors * bool(model.nsensor),
        "stages with nothing to do": idle & ~disabled & ~sensors,
    }
    for name in STAGES * constrained:
        stages[name.lower()] = int(getattr(BITS, f"mjDSBL_{name}", 0)) & ~disabled
    for name, bits in stages.items():
        if bits:
            yield Change(name, (("disableflags", (), bits),))
    if not constrained:
        return  # the features below act on constraints alone
    large = tuple(np.flatnonzero(collides & (model.geom_condim > 3)).tolist())
    if large:
        yield Change("condim above 3", (("geom_condim", large, 3),))
    if model.opt.iterations > FEW:
        yield Change(f"iterations above {FEW}", (("iterations", (), FEW),))
    if model.opt.tolerance < LOOSE:
        yield Change(f"tolerance below {LOOSE:g}", (("tolerance", (), LOOSE),))


def _never_touching(model: Any, collides: Any, met: set[tuple[int, ...]]) -> Iterator[Change]:
    """Yields changes without the collisions of geoms, and without the contact pairs, that never
    touch."""
    touched = set(chain.from_iterable(met))
    geoms = tuple(geom for geom in np.flatnonzero(collides).tolist() if geom not in touched)
    if geoms:
        off = (("geom_contype", geoms, 0), ("geom_conaffinity", geoms, 0))
        count = "1 geom that never touches"
        if len(geoms) > 1:
            count = f"{len(geoms)} geoms that never touch"
        yield Change(f"collisions of {count}", off)
    pairs = np.sort(np.stack([model.pair_geom1, model.pair_geom2], axis=1), axis=1).tolist()
    untouched = tuple(number for number, pair in enumerate(pairs) if tuple(pair) not in met)
    if untouched:
        name = f"{len(untouched)} contact pairs that never touch"
        yield Change(name, (("pair_margin", untouched, NEVER),))


def apply(model: Any, left_out: Sequence[Change]) -> None:
    """Applies changes to a compiled `model`, in place."""
    for change in left_out:
        for field, indices, value in change.sets:
            if indices:
                getattr(model, field).flat[list(indices)] = value
            elif field != "disableflags":
                setattr(model.opt, field, value)
            elif value > 0:
                model.opt.disableflags |= int(value)
            else:  # a negative value enables the stages
                model.opt.disableflags &= ~-int(value)
