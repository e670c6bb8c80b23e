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

Run = TypeVar("Run")
# A curve needs this many runs, and this ratio of steps, to show that it falls.
_LEAST_RUNS = 5
_LEAST_STEP_RATIO = 2.0**4


@dataclass(frozen=True)
class RunPoint:
    """The error and the cost of one run."""

    method: str
    step: float  # step size [s], or relative tolerance
    error: float  # error relative to the scales; infinite if the run diverged
    ns_per_second: float  # [ns] wall time per simulated second

    @property
    def speed(self) -> float:
        """The real-time factor: simulated time over wall time."""
        return 1e9 / self.ns_per_second if self.ns_per_second else math.inf


def work_precision_points(study: Study, scene: str) -> tuple[RunPoint, ...]:
    """Returns the error and cost of every run of `scene` whose cost is known, method by method,
    coarse to fine. A run that diverged has an infinite error and an infinite cost."""
    quantities = study.quantities(scene)
    points = []
    for series in study.convergence:
        cost = study.costs.get((scene, series.method))
        if series.scene != scene or cost is None:
            continue
        for run in series.measurements:
            if run.status in ("done", "diverged"):
                ns_per_second = math.inf
                if run.status == "done" and run.duration:
                    ns_per_second = run.steps * cost.ns_per_step / run.duration
                error = error_or_infinity(run, quantities)
                points.append(RunPoint(run.method, run.step, error, ns_per_second))
    return tuple(points)


def pareto_front(
    runs: Iterable[Run], cost_and_error: Callable[[Run], tuple[float, float]]
) -> tuple[Run, ...]:
    """Returns the Pareto front, from cheap to accurate: the runs that no other run beats in cost
    and in error."""
    smallest_error = math.inf
    front = []
    for run in sorted(runs, key=cost_and_error):
        _, error = cost_and_error(run)
        if error < smallest_error:
            smallest_error = error
            front.append(run)
    return tuple(front)


def error_or_infinity(run: Measurement, quantities: Quantities) -> float:
    """Returns the relative error of a run; infinite if the run lacks one of the quantities."""
    error = relative_error(run, quantities)
    return math.inf if math.isnan(error) else error


def errors_converge(curve: Iterable[tuple[float, float]]) -> bool:
    """Returns whether errors converge. `curve` has pairs of a step and an error, at least
    _LEAST_RUNS pairs over at least four octaves. Errors converge if the largest error is at least
    the square root of (largest step / smallest step) times the error at the smallest step."""
    finite = sorted((step, error) for step, error in curve if math.isfinite(error))
    if len(finite) < _LEAST_RUNS:
        return False
    smallest_step, finest_error = finite[0]
    largest_step, _ = finite[-1]
    if largest_step < _LEAST_STEP_RATIO * smallest_step:
        return False
    # The smallest positive number replaces an error of zero.
    error_ratio = max(error for _, error in finite) / max(finest_error, 5e-324)
    return error_ratio >= math.sqrt(largest_step / smallest_step)
