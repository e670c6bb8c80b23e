"""The table of trimmed models: the features that a model can leave out, and the time it saves."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.analytic.schemes import Scheme
from plumbob.engines.method import Method, meant
from plumbob.engines.study.extra_runs import StudyPlan, TrimmingRun
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.view.content import Table
from plumbob.reports.view.tables import table

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


def trimming(study: Study, scene: Scene) -> Table | None:
    """Returns the table with the cost of a step of the full model, of the model with disabled
    stages, and of the model that also lacks the geoms without effect, for one method of each
    scheme. None if no timing is stored for the scene."""
    timings = [(run.method, study.answer(run)) for run in _timings(scene, study.methods)]
    done = [(method, timed) for method, timed in timings if timed]
    if not done:
        return None
    rows = []
    for method, timed in done:
        # The page shows one cost for a method on a scene. The three costs of the trimming are
        # scaled so that the trimmed model has that cost.
        cost = study.costs.get((scene.name, method))
        scale = cost.ns_per_step / timed.ns_trimmed if cost else 1.0
        costs = [scale * ns for ns in (timed.ns_default, timed.ns_flags, timed.ns_trimmed)]
        rows.append((method, timed, costs))
    return table("trimming", done=rows, first=done[0][1], steps=STEPS)
