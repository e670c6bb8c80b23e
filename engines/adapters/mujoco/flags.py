"""The stages of a MuJoCo step that a model has nothing for, as the flags that leave them out."""

from __future__ import annotations

import mujoco
import numpy as np

BIT = mujoco.mjtDisableBit


def needless(model: mujoco.MjModel) -> int:
    """Disable flags of the stages that do nothing in `model`, whatever its state."""
    collides = _any(model, "geom_contype", "geom_conaffinity") or model.npair or model.nflex
    limited = _any(model, "jnt_limited", "tendon_limited")
    constrained = collides or limited or model.neq or _present(model, "frictionloss")
    fluid = model.opt.density or model.opt.viscosity
    # with both flags set MuJoCo skips every passive force, not springs and dampers alone
    passive = fluid or model.nflex or model.nplugin or _any(model, "body_gravcomp")
    idle = {
        BIT.mjDSBL_CONTACT: not collides,
        BIT.mjDSBL_CONSTRAINT: not constrained,
        BIT.mjDSBL_ACTUATION: not (model.nu or model.nplugin),
        BIT.mjDSBL_SPRING: not (passive or _present(model, "stiffness")),
        BIT.mjDSBL_DAMPER: not (passive or _present(model, "damping")),
        BIT.mjDSBL_SENSOR: not model.nsensor,
    }
    return sum(int(bit) for bit, without in idle.items() if without)


def _any(model: mujoco.MjModel, *fields: str) -> bool:
    return any(bool(np.any(getattr(model, field))) for field in fields)


def _present(model: mujoco.MjModel, word: str) -> bool:
    """Whether any field of the model that is named after `word` has an entry that is not zero."""
    return _any(model, *(field for field in dir(model) if word in field))
