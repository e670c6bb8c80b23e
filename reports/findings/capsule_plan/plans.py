"""Plans of the scenes that the findings share, and the naive plans beside them."""

from __future__ import annotations

from functools import cache

from plumbob.analytic.systems.planner import Plan
from plumbob.analytic.systems.planner import plan as find_plan
from plumbob.engines.study.results import Study
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import scenes as find_scenes
from plumbob.models.scene import Scene
from plumbob.models.tripod_capsule.plan import planned

SHOWN = "capsule-plan/near-free"  # whose path is drawn, and the quick profile's own


def scenes(study: Study) -> tuple[Scene, ...]:
    """The plans that a study has."""
    names = {scene.name for scene in study.scenes}
    return tuple(scene for scene in find_scenes("capsule-plan") if scene.name in names)


def plan_of(name: str) -> Plan:
    """The plan of a scene."""
    return planned(find_scene(name).parameters)


@cache
def naive(name: str) -> Plan:
    """The plan of equal manoeuvres for the same pose, under the same limits."""
    best = plan_of(name)
    return find_plan(best.capsule, best.goal, best.limits, best.track, best.start, equal=True)


def command(name: str, method: str = "", step: str = "") -> str:
    """What prints the plan of a scene, and with a method what an engine makes of it."""
    found = plan_of(name)
    to = f"{found.goal.x:g} {found.goal.y:g} {found.goal.heading:.17g}"
    run = f" --method {method} --step {step}" if method else ""
    return f"plumbob plan --to {to} --track {found.track}{run}"
