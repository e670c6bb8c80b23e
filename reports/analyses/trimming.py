"""The timings of trimmed models, which tell the time that a model saves by leaving out features."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.analytic.schemes import Scheme
from plumbob.engines.method import Method, meant
from plumbob.engines.study.extra_runs import StudyPlan, TrimmingRun
from plumbob.models.scene import Scene

STEPS, REPEATS = 150, 7  # steps and repeats of a timing: the ratio is exact to a few per cent
ENGINE = "mujoco"  # engine whose models have features and pipeline stages to leave out


def requests(plan: StudyPlan) -> Sequence[TrimmingRun]:
    """Returns the timings that the tables of a plan's scenes need."""
    timings = list[TrimmingRun]()
    for scene in plan.scenes:
        timings += _timings(scene, plan.methods)
    return timings


def _timings(scene: Scene, methods: Sequence[Method]) -> list[TrimmingRun]:
    """Returns a timing for one method of each scheme, at the middle step of the scene's steps."""
    schemes: dict[Scheme, str] = {}
    for method in methods:
        if method.engine == ENGINE and meant(method, scene):
            schemes.setdefault(method.scheme, method.name)
    step = scene.steps[len(scene.steps) // 2]
    return [TrimmingRun(scene.name, name, step, STEPS, REPEATS) for name in schemes.values()]
