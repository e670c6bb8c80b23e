"""Error against cost: the points of a study, and those that no other beats in both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from plumbob.engines.method import Method
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Study


@dataclass(frozen=True)
class Point:
    """One run: its largest error of the leading observable, and its cost."""

    method: str
    step: float  # [s], or the relative tolerance
    error: float  # in the observable's unit; infinite for a run that diverged
    ns_per_second: float  # [ns] of wall time per simulated second


def points(study: Study, scene: str) -> tuple[Point, ...]:
    """Every run of `scene` whose cost is known, by method, coarse to fine; runs that diverged at
    the end of the curve they belong to, with an infinite error and cost."""
    leading = study.leading(scene).name
    return tuple(
        Point(m.method, m.step, _error(m, leading), _cost(m, cost.ns_per_step))
        for convergence_study in study.convergence
        if convergence_study.scene == scene
        and (cost := study.costs.get((scene, convergence_study.method))) is not None
        for m in convergence_study.measurements
        if m.status in ("done", "diverged")
    )


def front(found: Sequence[Point]) -> tuple[Point, ...]:
    """The Pareto front: the points with no other that is both cheaper and more accurate, from
    cheap to accurate."""
    best = float("inf")
    kept = []
    for point in sorted(found, key=lambda p: (p.ns_per_second, p.error)):
        if point.error < best:
            best = point.error
            kept.append(point)
    return tuple(kept)


def of_method(found: Sequence[Point], method: Method) -> tuple[Point, ...]:
    """The points of one method, fine to coarse."""
    return tuple(sorted((p for p in found if p.method == method.name), key=lambda p: p.step))


def _error(found: Measurement, leading: str) -> float:
    return found.errors[leading].largest if leading in found.errors else float("inf")


def _cost(found: Measurement, ns_per_step: float) -> float:
    if found.status != "done" or not found.duration:
        return float("inf")
    return found.steps * ns_per_step / found.duration
