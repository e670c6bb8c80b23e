"""MuJoCo as an engine: its methods, and the way from a scene to a compiled model."""

from __future__ import annotations

from collections.abc import Mapping

from plumbob.engines.adapters.mujoco.methods import METHODS
from plumbob.engines.method import Engine, Method, Simulation
from plumbob.models.scene import Case


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Compile `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    from plumbob.engines.adapters.mujoco.simulation import compiled

    return compiled(case, method, step)


def model_error(case: Case, method: Method, step: float) -> Mapping[str, Mapping[str, float]]:
    """What the model itself adds to each observable, by reason; raises Unsupported."""
    from plumbob.engines.adapters.mujoco.translation import builder

    return builder(case.system).model_error(case.problem, case.scene.duration, method, step)


ENGINE = Engine("mujoco", "mujoco", METHODS, prepare, model_error)
