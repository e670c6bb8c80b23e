"""The table of engines and systems: error and cost at a step of 1 ms, and the smallest error at any
step; or the reason that an engine does not run a system."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import (
    REFERENCE_STEP,
    Measurement,
    reference_run,
    relative_error,
)
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.judge.expectations import expected

NOT_ENGINES = ("exact",)  # closed forms simulate nothing
ByEngine = dict[str, list[ConvergenceStudy]]


def numbers(study: Study) -> Record | None:
    """Returns the table with a row for each system and a cell for each engine; None if the study
    has only one engine. A row shows the scene of the system that the most engines run."""
    by_scene: dict[str, ByEngine] = {}
    order = [method.name for method in study.methods]  # an engine's default method is its first
    for series in sorted(study.convergence, key=lambda series: order.index(series.method)):
        engine = series.method.partition("/")[0]
        if engine not in NOT_ENGINES:
            by_scene.setdefault(series.scene, {}).setdefault(engine, []).append(series)
    engines = sorted(set().union(*by_scene.values()))
    if len(engines) < 2:
        return None
    rows = []
    for system in dict.fromkeys(scene.system for scene in study.scenes):
        scenes = [s for s in study.scenes if s.system == system and s.name in by_scene]
        if scenes:
            scene = max(scenes, key=lambda scene: _engines_done(by_scene[scene.name]))
            cells = [
                _cell(study, scene.name, engine, by_scene[scene.name].get(engine, ()))
                for engine in engines
            ]
            rows.append(Record(scene=scene.name, kind=scene.kind, cells=cells))
    return Record(step=REFERENCE_STEP, engines=engines, rows=rows)


def _engines_done(by_engine: Mapping[str, Sequence[ConvergenceStudy]]) -> int:
    """Returns the number of engines with a run that reached its end, on one scene."""
    return sum(any(map(_finished_runs, studies)) for studies in by_engine.values())


def _finished_runs(series: ConvergenceStudy) -> list[Measurement]:
    """Returns the runs of a convergence study that reached their end."""
    return [run for run in series.measurements if run.status == "done"]


def _cell(
    study: Study, scene: str, engine: str, of_engine: Sequence[ConvergenceStudy]
) -> Record:
    """Returns the cell of an engine on a scene: the error and the cost of the engine's first method
    at the step nearest to the reference step, and the smallest error of any method at any step.
    An engine's first method is its default one."""
    finished = [series for series in of_engine if _finished_runs(series)]
    if not finished:
        return _without_run(study, scene, engine, of_engine)
    quantities = study.quantities(scene)
    runs = [run for series in finished for run in _finished_runs(series)]
    errors = [(relative_error(run, quantities), run) for run in runs]
    smallest, best = min(errors, key=lambda pair: (math.isnan(pair[0]), pair[0]))
    default = finished[0]
    method = next(method for method in study.methods if method.name == default.method)
    shown = reference_run(default.measurements, method)
    assert shown is not None
    at_reference = [
        run
        for run in default.measurements
        if math.isclose(run.step, REFERENCE_STEP, rel_tol=1e-9)
    ]
    diverged = any(run.status == "diverged" for run in at_reference)
    error = math.nan if diverged else relative_error(shown, quantities)
    cost = None if diverged else study.costs.get((scene, method.name))
    return Record(
        method=method.name,
        control=method.control,
        step=shown.step,
        error=error if math.isfinite(error) else None,
        # [ms] computing time per simulated second
        cost=1e-6 * shown.steps * cost.ns_per_step / shown.duration if cost else None,
        smallest=smallest if math.isfinite(smallest) else None,
        smallest_with=best.method,
        smallest_at=best.step,
        diverged=diverged,
        why="",
    )


def _without_run(
    study: Study, scene: str, engine: str, of_engine: Sequence[ConvergenceStudy]
) -> Record:
    """Returns the cell of an engine without a run that reached its end. Its reason is the engine's
    own or the declared limit of one of its methods; empty if there is neither."""
    runs = [run for series in of_engine for run in series.measurements]
    limits = [
        expected(scene, method.name) for method in study.methods if method.engine == engine
    ]
    reasons = [run.reason for run in runs if run.status == "unsupported"]
    reasons += [limit.reason for limit in limits if limit.verdict == "unsupported"]
    return Record(
        method="",
        error=None,
        cost=None,
        diverged=any(run.status == "diverged" for run in runs),
        missing=any(run.status == "missing" for run in runs),
        why=reasons[0] if reasons else "",
    )


ERRORS_AND_COSTS = Analysis("engines/errors_and_costs", numbers)
