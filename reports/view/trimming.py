"""Features that a scene's model leaves out, what that saves, and that the motion is the same."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.analytic.schemes import Scheme
from plumbob.engines.method import Method, meant
from plumbob.engines.study.extra_runs import StudyPlan, TrimmingRun
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.view.content import Table
from plumbob.reports.view.tables import table

STEPS, REPEATS = 150, 7  # of a timing: enough for a ratio within a few per cent
ENGINE = "mujoco"  # whose models have parts and stages to leave out


def requests(plan: StudyPlan) -> Sequence[TrimmingRun]:
    """The timings that the tables of a plan's scenes show."""
    return [request for scene in plan.scenes for request in _of_scene(scene, plan.methods)]


def _of_scene(scene: Scene, methods: Sequence[Method]) -> list[TrimmingRun]:
    """A timing of one method of each scheme, at the middle one of the scene's steps."""
    schemes: dict[Scheme, str] = {}
    for m in methods:
        if m.engine == ENGINE and meant(m, scene):
            schemes.setdefault(m.scheme, m.name)
    step = scene.steps[len(scene.steps) // 2]
    return [TrimmingRun(scene.name, name, step, STEPS, REPEATS) for name in schemes.values()]


def trimming(study: Study, scene: Scene) -> Table | None:
    """Cost of a step with everything in, with stages disabled, and without unfelt geoms too, for
    one method of each scheme; None where MuJoCo does not run the scene."""
    timings = [(asked.method, study.answer(asked)) for asked in _of_scene(scene, study.methods)]
    done = [(method, timed) for method, timed in timings if timed]
    if not done:
        return None
    rows = []
    for method, timed in done:
        # The page has one cost of a method on a scene: the three are in the proportion of here.
        cost = study.costs.get((scene.name, method))
        scale = cost.ns_per_step / timed.ns_trimmed if cost else 1.0
        costs = [scale * ns for ns in (timed.ns_default, timed.ns_flags, timed.ns_trimmed)]
        rows.append((method, timed, costs))
    return table("trimming", done=rows, first=done[0][1], steps=STEPS)
