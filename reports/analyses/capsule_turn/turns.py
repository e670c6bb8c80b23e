"""The check manoeuvre of a turn for each epsilon, and facts of its exact motion."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of
from plumbob.reports.analyses.measurements import problem


def scene_name(epsilon: float) -> str:
    """Returns the name of the scene with the turn of this epsilon, which lasts until all rests."""
    return f"capsule-turn/{epsilon}"


@cache
def turn(epsilon: float) -> TurnManoeuvre:
    """Returns the check manoeuvre with the half time tau = epsilon T."""
    manoeuvre = problem(scene_name(epsilon)).motion.manoeuvre
    assert isinstance(manoeuvre, TurnManoeuvre)
    return manoeuvre


@cache
def facts(epsilon: float) -> Mapping[str, float]:
    """Returns angles, velocities and times of the exact motion and of the formulas, by name."""
    scene = find_scene(scene_name(epsilon))
    return system_of(scene).facts(problem(scene.name))
