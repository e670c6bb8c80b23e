"""The argument of `--like`: the user's model file, and the scenes and methods to compare it
with."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.abilities import UserSettings
from plumbob.engines.method import USER_METHOD, Method
from plumbob.engines.registry import find_engine, installed
from plumbob.models.scene import Scene

# A line at four headings shows fastest whether the friction settings are accurate.
LINES = tuple(f"capsule-line/heading-{angle:03d}" for angle in (0, 30, 45, 90))
SCENES = ",".join(("*", *LINES))
METHODS = ",".join(
    (
        "mujoco/euler",
        "mujoco/implicitfast",
        "mujoco/rk4",
        "mujoco/rk4+midpoint",
        "mujoco/euler+elliptic+noslip",
        "mujoco/euler+coulomb",
        "mujoco/euler+reduced",
        "pymunk",
        "ode/leapfrog",
        "ode/rk4",
    )
)
LARGEST_RATIO = 2.5  # largest ratio of two neighbouring step sizes


def own_method(path: str) -> Method:
    """Returns the method that has the settings of the user's file `path`. Raises ParameterError."""
    engine = find_engine(USER_METHOD.partition("/")[0])
    settings = engine.ability(UserSettings)
    if settings is None or not installed(engine):
        raise ParameterError("like", path, "measured with MuJoCo, which is not installed")
    return settings.read(Path(path))


def beside(scene: Scene, user_method: Method) -> Scene:
    """Returns `scene` with the user's step among its step sizes, so that other methods are measured
    at that step too. If the user's step is far outside the scene's step sizes, returns `scene`
    unchanged."""
    step = user_method.step_sizes[0]
    if step in scene.steps or not min(scene.steps) <= step <= LARGEST_RATIO * max(scene.steps):
        return scene
    return replace(scene, steps=tuple(sorted((*scene.steps, step), reverse=True)))
