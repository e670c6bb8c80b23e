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
from plumbob.reports.view.site.views import SceneView, SystemView, scene_view, system_view

MANY = 8  # scenes: fewer are drawn before another process is ready
LIMIT = 600.0  # [s]: a part of a page that takes longer hangs


def system_views(
    study: Study,
    systems: Sequence[System],
    judged: Judgements,
    jobs: int | Workers = 1,
) -> list[SystemView]:
    """A view of each system with the scenes of `study`, the same for any number of processes, of
    which `jobs`, or those given, are used where there is much to draw."""
    drawn: Mapping[str, SceneView] = {}
    with workers_of(jobs) as workers:
        if workers.count > 1 and len(study.scenes) >= MANY:
            drawn = _side_by_side(study, systems, judged, workers)
    return [system_view(study, system, judged, drawn) for system in systems]


def _side_by_side(
    study: Study, systems: Sequence[System], judged: Judgements, workers: Workers
) -> dict[str, SceneView]:
    """The view of each scene by its name, without those whose process died, which another process
    is to draw."""
    views: dict[str, SceneView] = {}
    with tempfile.TemporaryDirectory(prefix="plumbob-") as folder:
        file = Path(folder) / "study.pickle"
        file.write_bytes(pickle.dumps((study, judged), pickle.HIGHEST_PROTOCOL))
        tasks = [
            Task(scene.name, _scene, (str(file), scene.name), LIMIT, scene.system)
            for scene in _longest_first(study.scenes)
        ]
        for task, view in workers.results(tasks):
            if not isinstance(view, Lost):
                views[task.key] = view
    return views


def _longest_first(scenes: Sequence[Scene]) -> list[Scene]:
    """Scenes with many parameters first: each is changed, and the exact motion found anew."""
    return sorted(scenes, key=lambda scene: -len(parameters_of(scene)))


def _scene(file: str, name: str) -> SceneView:
    """The view of a scene of the study in `file`."""
    study, judged = _read(file)
    scene = next(scene for scene in study.scenes if scene.name == name)
    return scene_view(study, find_system(scene.system), scene, judged)


@lru_cache(maxsize=1)
def _read(file: str) -> tuple[Study, Judgements]:
    study, judged = pickle.loads(Path(file).read_bytes())
    return study, judged
