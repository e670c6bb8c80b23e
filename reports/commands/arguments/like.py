"""The argument of `--like`: a user's model file, and the methods to compare it with by default."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.abilities import UserSettings
from plumbob.engines.method import USER_METHOD, Method
from plumbob.engines.registry import find_engine, installed
from plumbob.models.scene import Scene

# A line at four headings shows soonest how well a setting's friction works.
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
LARGEST_RATIO = 2.5  # the largest ratio of two step sizes in a row


def own_method(path: str) -> Method:
    """The method that the settings in the file `path` are; raises ParameterError."""
    engine = find_engine(USER_METHOD.partition("/")[0])
    settings = engine.ability(UserSettings)
    if settings is None or not installed(engine):
        raise ParameterError("like", path, "measured with MuJoCo, which is not installed")
    return settings.read(Path(path))


def beside(scene: Scene, user_method: Method) -> Scene:
    """The scene with the user's step among its step sizes, for other methods to be measured at it
    too; unchanged where that step is far outside them."""
    step = user_method.step_sizes[0]
    if step in scene.steps or not min(scene.steps) <= step <= LARGEST_RATIO * max(scene.steps):
        return scene
    return replace(scene, steps=tuple(sorted((*scene.steps, step), reverse=True)))
