"""The table of largest stable steps on the first screen, for a few motions and methods."""

from __future__ import annotations

from plumbob.reports.advice.recommend import DEFAULT_METHOD
from plumbob.reports.view.method_results import MethodResult, Results
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


def largest_step(all_results: Results) -> View | None:
    """The table of the largest stable steps, and the result of the default method on the first
    scene where that method has a limit; None if the default method has none on any scene."""
    limited: dict[str, dict[str, MethodResult]] = {scene: {} for scene in SCENES}
    for (scene, method), result in all_results.items():
        if scene in limited and result.limit:
            limited[scene][method] = result
    of_default = [
        results[DEFAULT_METHOD] for results in limited.values() if DEFAULT_METHOD in results
    ]
    if not of_default:
        return None
    ranges = {scene: results for scene, results in limited.items() if results}
    methods = [name for name in METHODS if any(name in results for results in ranges.values())]
    return View(
        default=of_default[0], table=table("stable_steps", ranges=ranges, names=methods)
    )
