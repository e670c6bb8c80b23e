"""The views of a study's systems, worked out in this process or side by side in several."""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path

from plumbob.engines.study.results import Study
from plumbob.engines.workers import Lost, Task, Workers, workers_of
from plumbob.models.registry import find_system
from plumbob.models.scene import Scene, System
from plumbob.reports.judge.sensitivity import parameters_of
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.view.site.views import (
    Said,
    SceneView,
    Sections,
    SystemView,
    in_order,
    said_of,
    scene_view,
    system_view,
)

MANY = 8  # scenes: fewer are drawn before another process is ready
LIMIT = 600.0  # [s]: a part of a page that takes longer hangs

Part = tuple[Said | None, SceneView]  # of a system what there is to say, with its first scene


def system_views(
    study: Study,
    systems: Sequence[System],
    judged: Judgements,
    section: Sections,
    jobs: int | Workers = 1,
) -> list[SystemView]:
    """A view of each system with the scenes of `study`, the same for any number of processes, of
    which `jobs`, or those given, are used where there is much to draw; `section` must have a name
    there."""
    parts: Mapping[str, Part] = {}
    with workers_of(jobs) as workers:
        if workers.count > 1 and len(study.scenes) >= MANY:
            parts = _side_by_side(study, systems, judged, section, workers)
    views = []
    for system in systems:
        scenes = in_order(study, system)
        drawn_parts = {scene.name: parts[scene.name] for scene in scenes if scene.name in parts}
        about = drawn_parts[scenes[0].name][0] if scenes[0].name in drawn_parts else None
        drawn = {name: view for name, (_, view) in drawn_parts.items()}
        views.append(system_view(study, system, judged, section, about, drawn))
    return views


def _side_by_side(
    study: Study, systems: Sequence[System], judged: Judgements, section: Sections, workers: Workers
) -> dict[str, Part]:
    """The view of each scene by its name, the first of a system with what there is to say of that;
    without those whose process died, which another process is to draw."""
    first = [in_order(study, system)[0] for system in systems]
    others = [scene for scene in study.scenes if scene not in first]
    views: dict[str, Part] = {}
    with tempfile.TemporaryDirectory(prefix="plumbob-") as folder:
        file = Path(folder) / "study.pickle"
        file.write_bytes(pickle.dumps((study, judged, section), pickle.HIGHEST_PROTOCOL))
        tasks = [
            Task(scene.name, _part, (str(file), scene.name, scene in first), LIMIT, scene.system)
            for scene in (*_longest_first(first), *_longest_first(others))
        ]
        for task, part in workers.results(tasks):
            if not isinstance(part, Lost):
                views[task.key] = part
    return views


def _longest_first(scenes: Sequence[Scene]) -> list[Scene]:
    """Scenes with many parameters first: each is changed, and the exact motion found anew."""
    return sorted(scenes, key=lambda scene: -len(parameters_of(scene)))


def _part(file: str, name: str, first: bool) -> Part:
    """The view of a scene of the study in `file`, with what there is to say of its system."""
    study, judged, section = _read(file)
    scene = next(scene for scene in study.scenes if scene.name == name)
    system = find_system(scene.system)
    of_system = section(system.name)
    about = said_of(study, system, judged, of_system) if first else None
    return about, scene_view(study, system, scene, judged, of_system)


@lru_cache(maxsize=1)
def _read(file: str) -> tuple[Study, Judgements, Sections]:
    study, judged, section = pickle.loads(Path(file).read_bytes())
    return study, judged, section
