"""The controls that a policy gives while a user's model runs at its own step."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.options import collected
from plumbob.engines.adapters.mujoco.terms import state_of
from plumbob.engines.own_motion import AskedPolicy, periods


def recorded(model: Any, data: Any, loop: AskedPolicy, period: float, duration: float) -> Array:
    """Returns the controls of a compiled `model`, shape (periods, actuators), that a new run of a
    policy gives from the mjData on. The policy is asked at the begin of each `period` [s], rounded
    to a multiple of the model's step. Raises ParameterError and NotControlled."""
    held = max(1, round(period / model.opt.timestep))
    controls = list[Array]()
    ask = loop.new_run()
    with collected():
        for _ in range(periods(duration, held * model.opt.timestep)):
            controls.append(ask(float(data.time), state_of(data)))
            data.ctrl[:] = controls[-1]
            mujoco.mj_step(model, data, held)
    return np.array(controls)
