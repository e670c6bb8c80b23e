"""The controls that a policy gives while a user's model runs at its own step."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.options import collected
from plumbob.engines.own_motion import Policy, periods, policy_name
from plumbob.models.border import must_be, shortened
from plumbob.models.entry_points import on_stderr


def recorded(model: Any, data: Any, policy: Policy, period: float, duration: float) -> Array:
    """Returns controls of a compiled `model`, shape (periods, actuators), that `policy` gives from
    the mjData on. The policy is called with time [s], positions and velocities at the beginning of
    each `period` [s], rounded to a multiple of the model's step. Raises ParameterError."""
    held = max(1, round(period / model.opt.timestep))
    controls = list[Array]()
    with collected(), on_stderr():
        for _ in range(periods(duration, held * model.opt.timestep)):
            state = float(data.time), np.array(data.qpos), np.array(data.qvel)
            controls.append(_checked_control(policy, state, int(model.nu)))
            data.ctrl[:] = controls[-1]
            mujoco.mj_step(model, data, held)
    return np.array(controls)


def _checked_control(policy: Policy, state: tuple[float, Array, Array], count: int) -> Array:
    """Returns the control that a policy gives in a state, shape (count,). Raises ParameterError."""
    wanted = f"a function of time, qpos and qvel that returns {count} finite numbers"
    name = policy_name(policy)
    with must_be(wanted, "policy", name):
        control = np.asarray(policy(*state), dtype=float).reshape(-1)
    if control.shape != (count,) or not np.isfinite(control).all():
        raise ParameterError(
            "policy", name, f"{wanted}, not {shortened(str(control.tolist()))}"
        )
    return control
