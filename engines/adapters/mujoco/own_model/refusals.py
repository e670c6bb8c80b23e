"""Features of a MuJoCo model that no continuous motion has, for which an audit refuses it."""

from __future__ import annotations

import copy
from typing import Any

import mujoco
import numpy as np

from plumbob.engines.adapters.mujoco.own_model.field import VANISHING
from plumbob.engines.own_motion import NotCertifiable

CALLBACKS = ("act_bias", "act_dyn", "act_gain", "contactfilter", "control", "passive", "sensor")


def check_continuous(model: Any) -> None:
    """Raises NotCertifiable for a feature with a state, or with a use of the step, that no
    continuous motion has."""
    option = model.opt
    enabled = mujoco.mjtEnableBit
    set_callbacks = [
        name for name in CALLBACKS if getattr(mujoco, f"get_mjcb_{name}")() is not None
    ]
    reasons = (
        (
            bool(model.nplugin and sum(model.plugin_statenum)),
            "a plugin with a state of its own",
        ),
        (_jumps(model), "a plugin with a slew limit, which its first step is free of"),
        (bool(set_callbacks), f"a callback: mjcb_{', mjcb_'.join(set_callbacks)}"),
        (bool(np.any(getattr(model, "actuator_delay", 0.0))), "an actuator with a delay"),
        (bool(np.any(getattr(model, "sensor_delay", 0.0))), "a sensor with a delay"),
        (bool(np.any(getattr(model, "flex_damping", 0.0))), "a flex with damping"),
        (bool(option.enableflags & enabled.mjENBL_SLEEP), "sleeping bodies"),
        (option.noslip_iterations > 0, "the noslip solver, which corrects after the fact"),
        (model.nv == 0, "no degree of freedom"),
    )
    for applies, what in reasons:
        if applies:
            raise NotCertifiable(f"the model has {what}")


def _jumps(model: Any) -> bool:
    """Whether a plugin's activation is set within the first step, however short the step is."""
    if not (model.nplugin and model.na):
        return False
    model = copy.copy(model)
    low, high = model.actuator_ctrlrange.T
    far = np.where(abs(low) > abs(high), low, high)
    rates = []
    for model.opt.timestep in (VANISHING, 2.0 * VANISHING):
        data = mujoco.MjData(model)
        data.ctrl[:] = np.where(model.actuator_ctrllimited, far, 1.0)
        mujoco.mj_forward(model, data)
        rates.append(np.array(data.act_dot))
    return not np.allclose(rates[0], rates[1], rtol=0.1)
