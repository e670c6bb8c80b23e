"""The largest step that one may take, on the first screen: a few motions and a few methods."""

from __future__ import annotations

from collections.abc import Mapping

from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.advice.recommend import DEFAULT_METHOD
from plumbob.reports.view.site.views import View
from plumbob.reports.view.step_ranges import SCENES, StepRange, step_ranges
from plumbob.reports.view.tables import table

METHODS = (
    *(f"mujoco/{integrator}" for integrator in ("euler", "implicit", "implicitfast", "rk4")),
    "pymunk/default",
    "ode/rk4",
)


def largest_step(study: Study) -> View | None:
    """Of the first motion on which the default settings have a limit; None without one."""
    ranges: dict[str, Mapping[str, StepRange]] = {
        scene.name: {of.method: of for of in step_ranges(study, scene) if of.limit}
        for scene in sorted(_shown(study), key=lambda scene: SCENES.index(scene.name))
    }
    first = next((name for name, of in ranges.items() if DEFAULT_METHOD in of), None)
    if first is None:
        return None
    methods = [name for name in METHODS if any(name in of for of in ranges.values())]
    (scene,) = [scene for scene in study.scenes if scene.name == first]
    shown = table("stable_steps", ranges=ranges, names=methods)
    return View(scene=scene, default=ranges[first][DEFAULT_METHOD], table=shown)


def _shown(study: Study) -> list[Scene]:
    return [scene for scene in study.scenes if scene.name in SCENES]
