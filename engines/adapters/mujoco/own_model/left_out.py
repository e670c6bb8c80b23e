"""Features that a MuJoCo model can omit on a motion: collisions, stages, iterations."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import mujoco
import numpy as np

from plumbob.engines.adapters.mujoco.options import needless_stages
from plumbob.engines.own_motion import Change

BITS = mujoco.mjtDisableBit
FEW = 5  # solver iterations to try
LOOSE = 1e-5  # solver tolerance to try, where the model's is smaller
STAGES = ("ISLAND", "WARMSTART", "MIDPHASE")  # of any model; a motion may not need them


def changes(model: Any, met: set[int]) -> Iterator[Change]:
    """Features that may be left out of `model`, whose geoms `met` are all that touched."""
    collides = (model.geom_contype | model.geom_conaffinity) != 0
    if never := tuple(i for i in np.flatnonzero(collides).tolist() if i not in met):
        off = (("geom_contype", never, 0), ("geom_conaffinity", never, 0))
        which = f"{len(never)} geoms that never touch" if never[1:] else "1 geom that never touches"
        yield Change(f"collisions of {which}", off)
    flags, idle = int(model.opt.disableflags), needless_stages(model)
    if model.nsensor:
        yield Change("sensors", (_flag(BITS.mjDSBL_SENSOR),))
    unused = idle & ~flags & ~int(BITS.mjDSBL_SENSOR)
    if unused:
        yield Change("stages with nothing to do", (("disableflags", (), unused),))
    if idle & int(BITS.mjDSBL_CONSTRAINT):
        return  # nothing below has anything to do
    for name in STAGES:
        bit = getattr(BITS, f"mjDSBL_{name}", None)
        if bit is not None and not flags & int(bit):
            yield Change(name.lower(), (_flag(bit),))
    if model.opt.iterations > FEW:
        yield Change(f"iterations above {FEW}", (("iterations", (), FEW),))
    if model.opt.tolerance < LOOSE:
        yield Change(f"tolerance below {LOOSE:g}", (("tolerance", (), LOOSE),))


def _flag(bit: Any) -> tuple[str, tuple[int, ...], float]:
    return ("disableflags", (), int(bit))


def apply(model: Any, left_out: Sequence[Change]) -> None:
    """Leave out of a compiled `model`, in place."""
    for change in left_out:
        for field, indices, value in change.sets:
            if indices:
                getattr(model, field).flat[list(indices)] = value
            elif field != "disableflags":
                setattr(model.opt, field, value)
            elif value > 0:
                model.opt.disableflags |= int(value)
            else:  # the stages are enabled
                model.opt.disableflags &= ~-int(value)
