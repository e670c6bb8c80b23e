"""The table of trimmed models: the features that a model can leave out, and the time it saves."""

from __future__ import annotations

from plumbob.engines.study.extra_runs import TrimmingRun
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.view.content import Table
from plumbob.reports.view.tables import table


def trimming_table(study: Study, scene: Scene) -> Table | None:
    """Returns the table with the computing time per simulated second of the full model, of the
    model with disabled stages, and of the model that also lacks the geoms without effect, for one
    method of each scheme. None if no timing is stored for the scene."""
    timings = [run for run in study.extras if isinstance(run, TrimmingRun)]
    by_method = {run.method: run for run in timings if run.scene == scene.name}
    runs = [by_method[method.name] for method in study.methods if method.name in by_method]
    done = [run for run in runs if study.extras[run]]
    if not done:
        return None
    rows = []
    for run in done:
        method = run.method
        timed = study.extras[run]
        # The page shows one cost for a method on a scene. The three costs of the trimming are
        # scaled so that the trimmed model has that cost.
        cost = study.costs.get((scene.name, method))
        scale = cost.ns_per_step / timed.ns_trimmed if cost else 1.0
        per_second = scale / run.step
        costs = [per_second * ns for ns in (timed.ns_default, timed.ns_flags, timed.ns_trimmed)]
        rows.append((method, timed, costs))
    about = {"steps": done[0].steps, "step": done[0].step}
    return table("trimming", done=rows, first=rows[0][1], **about)
