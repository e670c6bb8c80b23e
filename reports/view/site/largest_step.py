"""The table of largest stable steps on the first screen, for a few motions and methods."""

from __future__ import annotations

from plumbob.reports.advice.recommend import DEFAULT_METHOD
from plumbob.reports.view.method_results import Results
from plumbob.reports.view.site.views import View
from plumbob.reports.view.tables import table

# The quick profile predicts the stability limits of these scenes.
SCENES = (
    "simple-pendulum/free-large",
    "cone-pendulum/rotating-base",
    "cone-pendulum/fast-platform",
    "linear-pendulum/overdamped",
    "free-body/flip",
)
METHODS = (
    *(f"mujoco/{integrator}" for integrator in ("euler", "implicit", "implicitfast", "rk4")),
    "pymunk/default",
    "ode/rk4",
)


def largest_step(every: Results) -> View | None:
    """The table of the largest stable steps, and the result of the default method on the first
    scene where that method has a limit; None if the default method has none on any scene."""
    ranges = {
        scene: {name: of for (where, name), of in every.items() if where == scene and of.limit}
        for scene in SCENES
    }
    first = next((of[DEFAULT_METHOD] for of in ranges.values() if DEFAULT_METHOD in of), None)
    if first is None:
        return None
    ranges = {scene: of for scene, of in ranges.items() if of}
    methods = [name for name in METHODS if any(name in of for of in ranges.values())]
    return View(default=first, table=table("stable_steps", ranges=ranges, names=methods))
