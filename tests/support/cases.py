"""Cases for sensitivity tests: one scene is run and compared with the answer to another."""

from __future__ import annotations

from dataclasses import replace

from plumbob.engines.method import Method
from plumbob.engines.study.measurement import Measurement, measure
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Case, Scene
from plumbob.reports.judge.verdict import judge


def held_against(case: Case, other: Case) -> Case:
    """The case with the exact motion of `other` and its predictions."""
    return replace(case, reference=other.reference, errors=other.errors)


def run_of(
    method: Method, scene: Scene, step: float, other: Scene | None = None
) -> tuple[Measurement, Trajectory]:
    """One run of a scene, compared with its own answer or that of `other`, and its samples."""
    case = case_of(scene)
    if other is not None:
        case = held_against(case, case_of(other))
    found, trajectory = measure(case, method, step)
    assert trajectory is not None, found
    return found, trajectory


def verdict_of(found: Measurement, method: Method) -> str:
    """The verdict on a run of a scene as it stands in its system."""
    return judge(found, system_of(find_scene(found.scene)), method).verdict
