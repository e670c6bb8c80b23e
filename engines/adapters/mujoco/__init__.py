"""MuJoCo as an engine: its methods, and the way from a scene to a compiled model."""

from __future__ import annotations

from collections.abc import Mapping

from plumbob.engines.adapters.mujoco.methods import METHODS
from plumbob.engines.method import Engine, Method, Simulation
from plumbob.models.scene import Scene, System


def prepare(system: System, scene: Scene, method: Method, step: float) -> Simulation:
    """Compile `scene` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    from plumbob.engines.adapters.mujoco.simulation import compiled

    return compiled(system, scene, method, step)


def regularisation(
    system: System, scene: Scene, method: Method, step: float
) -> Mapping[str, Mapping[str, float]]:
    """What the model itself adds to each observable, by reason; raises Unsupported."""
    from plumbob.engines.adapters.mujoco.translation import builder

    problem = system.problem(scene.parameters)
    return builder(system).regularisation(problem, scene.duration, method, step)


ENGINE = Engine("mujoco", "mujoco", METHODS, prepare, regularisation)
