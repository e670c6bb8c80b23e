"""Errors against costs: the points of a study, and its Pareto front.

An error is the largest error of the quantities of interest relative to their scales. The error of a
quantity of scale 1 is in the observable's own unit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TypeVar

from plumbob.engines.study.measurement import Measurement, relative_error
from plumbob.engines.study.results import Quantities, Study

T = TypeVar("T")
# A curve needs this many runs, and this ratio of steps, to show that it falls.
_RUNS = 5
_OCTAVES = 2.0**4


@dataclass(frozen=True)
class Point:
    """The error and the cost of one run."""

    method: str
    step: float  # step size [s], or relative tolerance
    error: float  # error relative to the scales; infinite if the run diverged
    ns_per_second: float  # [ns] wall time per simulated second

    @property
    def speed(self) -> float:
        """The real-time factor: simulated time over wall time."""
        return 1e9 / self.ns_per_second if self.ns_per_second else math.inf


def points(study: Study, scene: str) -> tuple[Point, ...]:
    """Returns the error and cost of every run of `scene` whose cost is known, method by method,
    coarse to fine. A run that diverged has an infinite error and an infinite cost."""
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
    """Returns the Pareto front, from cheap to accurate: the runs that no other run beats in cost
    and in error."""
    best = math.inf
    kept = []
    for run in sorted(runs, key=cost_and_error):
        if (error := cost_and_error(run)[1]) < best:
            best = error
            kept.append(run)
    return tuple(kept)


def error_of(run: Measurement, quantities: Quantities) -> float:
    """Returns the relative error of a run; infinite if the run lacks one of the quantities."""
    error = relative_error(run, quantities)
    return math.inf if math.isnan(error) else error


def converging(curve: Iterable[tuple[float, float]]) -> bool:
    """Whether errors converge. `curve` are pairs of step and error. They must be _RUNS or more and
    span four octaves or more. The largest error must be larger than the error at the smallest step
    by the square root of the ratio of the steps, or more."""
    done = sorted((step, error) for step, error in curve if math.isfinite(error))
    if len(done) < _RUNS or done[-1][0] < _OCTAVES * done[0][0]:
        return False
    fall = max(error for _, error in done) / max(done[0][1], 5e-324)
    return fall >= math.sqrt(done[-1][0] / done[0][0])
