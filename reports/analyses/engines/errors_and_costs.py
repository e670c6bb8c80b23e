"""Every engine of a study on every system: its error and cost at a step of 1 ms, and its smallest
error at any step."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import relative_error
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record

STEP = 1e-3  # [s], at which engines are compared
NOT_ENGINES = ("exact",)  # closed forms


def numbers(study: Study) -> Record | None:
    """A row a system and a cell an engine; None where the study has one engine alone."""
    by_scene: dict[str, list[ConvergenceStudy]] = {}
    for series in study.convergence:
        if _engine(series) not in NOT_ENGINES:
            by_scene.setdefault(series.scene, []).append(series)
    engines = sorted({_engine(series) for every in by_scene.values() for series in every})
    if len(engines) < 2:
        return None
    systems = dict.fromkeys(scene.system for scene in study.scenes)
    rows = [
        _row(study, _of_most_engines(system, by_scene), engines)
        for system in systems
        if any(name.partition("/")[0] == system for name in by_scene)
    ]
    return Record(step=STEP, engines=engines, rows=rows)


def _engine(series: ConvergenceStudy) -> str:
    return series.method.partition("/")[0]


def _of_most_engines(
    system: str, by_scene: dict[str, list[ConvergenceStudy]]
) -> list[ConvergenceStudy]:
    """The studies of the scene of a system that the most engines run; the first of several."""
    of_system = [every for name, every in by_scene.items() if name.partition("/")[0] == system]
    return max(of_system, key=lambda every: len({_engine(series) for series in every}))


def _row(study: Study, every: Sequence[ConvergenceStudy], engines: Iterable[str]) -> Record:
    """A scene with each engine's cell, None where an engine does not run it."""
    cells = {engine: [s for s in every if _engine(s) == engine] for engine in engines}
    return Record(
        scene=every[0].scene,
        cells=[_cell(study, of_engine) if of_engine else None for of_engine in cells.values()],
    )


def _cell(study: Study, of_engine: Sequence[ConvergenceStudy]) -> Record:
    """The errors of an engine's methods on a scene. At STEP the engine's first method stands, the
    default one; the smallest error is that of any method at any step."""
    quantities = study.quantities(of_engine[0].scene)
    smallest: tuple[float, str, float] = (math.inf, "", math.nan)
    for series in of_engine:
        for run in series.measurements:
            error = relative_error(run, quantities)
            if error < smallest[0]:
                smallest = (error, series.method, run.step)
    first = of_engine[0]
    at_step = [run for run in first.measurements if math.isclose(run.step, STEP, rel_tol=1e-9)]
    error = relative_error(at_step[0], quantities) if at_step else math.nan
    cost = study.costs.get((first.scene, first.method))
    return Record(
        method=first.method,
        error=error if math.isfinite(error) else None,
        diverged=math.isinf(error),
        # [ms] of computing for a simulated second
        cost=None if cost is None else cost.ns_per_step * 1e-6 / STEP,
        smallest=smallest[0] if math.isfinite(smallest[0]) else None,
        smallest_with=smallest[1],
        smallest_at=smallest[2],
    )


ERRORS_AND_COSTS = Analysis("engines/errors_and_costs", numbers)
