"""Error against cost: the points of a study, and those that no other beats in both.

An error is that of quantities of interest, relative to their scales; in a quantity of scale 1 it is
in the observable's own unit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TypeVar

from plumbob.engines.study.measurement import Measurement, relative_error
from plumbob.engines.study.results import Quantities, Study

T = TypeVar("T")
# that a curve has at least, to show that it falls
_RUNS = 5
_OCTAVES = 2.0**4


@dataclass(frozen=True)
class Point:
    """One run: its error and its cost."""

    method: str
    step: float  # [s], or the relative tolerance
    error: float  # relative to the scales; infinite for a run that diverged
    ns_per_second: float  # [ns] of wall time per simulated second

    @property
    def speed(self) -> float:
        """The real-time factor: simulated time over wall time."""
        return 1e9 / self.ns_per_second if self.ns_per_second else math.inf


def points(study: Study, scene: str) -> tuple[Point, ...]:
    """Every run of `scene` whose cost is known, by method, coarse to fine, with the
    error of what the scene is about; runs that diverged at the end of the curve
    they belong to, with an infinite error and cost."""
    about = study.quantities(scene)
    return tuple(
        Point(
            m.method,
            m.step,
            error_of(m, about),
            m.steps * cost.ns_per_step / m.duration
            if m.status == "done" and m.duration
            else math.inf,
        )
        for convergence_study in study.convergence
        if convergence_study.scene == scene
        and (cost := study.costs.get((scene, convergence_study.method)))
        for m in convergence_study.measurements
        if m.status in ("done", "diverged")
    )


def front(
    runs: Iterable[T], cost_and_error: Callable[[T], tuple[float, float]]
) -> tuple[T, ...]:
    """The Pareto front: the runs with no other that is both cheaper and more accurate, from cheap
    to accurate."""
    best = math.inf
    kept = []
    for run in sorted(runs, key=cost_and_error):
        if (error := cost_and_error(run)[1]) < best:
            best = error
            kept.append(run)
    return tuple(kept)


def error_of(run: Measurement, quantities: Quantities) -> float:
    """The relative error of a run; infinite where it leaves a quantity out too."""
    error = relative_error(run, quantities)
    return math.inf if math.isnan(error) else error


def converging(curve: Iterable[tuple[float, float]]) -> bool:
    """Whether the largest error at a step or below, of steps and errors, falls over at least four
    octaves, no slower than the square root of the step."""
    done = sorted((step, error) for step, error in curve if math.isfinite(error))
    if len(done) < _RUNS or done[-1][0] < _OCTAVES * done[0][0]:
        return False
    fall = max(error for _, error in done) / max(done[0][1], 5e-324)
    return fall >= math.sqrt(done[-1][0] / done[0][0])
