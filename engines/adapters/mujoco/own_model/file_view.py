"""A user's model as MuJoCo's viewer shows it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.own_model.model import start_data
from plumbob.engines.adapters.mujoco.user_file import user_model
from plumbob.engines.adapters.mujoco.viewing import MujocoView
from plumbob.engines.own_motion import Start


def view_of_file(path: Path, start: Start, controls: Array | None, period: float) -> MujocoView:
    """Returns a user's model at its start: at its first keyframe if it has one and `start` names
    none. `controls`, shape (periods, nu), are held for a `period` [s] each, the last one on and on;
    None keeps those of the start. Raises ParameterError and NotCertifiable."""
    model, _, start = user_model(path, start)
    if model.nkey and start == Start():
        start = Start(keyframe=0)
    data = start_data(model, start)
    held = max(1, round(period / model.opt.timestep))

    def of_steps(steps: Array) -> Array | None:
        """Returns the controls of the steps with these numbers."""
        if controls is None:
            return None
        rows: Array = controls[np.minimum(steps.astype(int) // held, len(controls) - 1)]
        return rows

    return MujocoView(model, data, of_steps)
