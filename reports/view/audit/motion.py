"""The figures of an audit's answer that its template needs beside the audit itself."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from operator import attrgetter
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.reference import OUT_OF_TIME, RESOLVED
from plumbob.engines.audit.step_errors import TARGETS, Cheapest, Compared, StepError, horizon
from plumbob.reports.advice.work_precision import front

SHOWN = 5  # errors of a halving
COURSES = 4  # steps of the own integrator in the figure over time


@dataclass(frozen=True)
class Motion:
    """An audit, and what follows from it."""

    audit: Audit
    targets: tuple[float, ...] = TARGETS

    @property
    def steps(self) -> Compared:
        """All steps that were run."""
        assert self.audit.found is not None
        return self.audit.found

    @cached_property
    def runs(self) -> tuple[StepError, ...]:
        """Those of the own integrator at the own step and halves of it."""
        audit = self.audit
        return tuple(
            run
            for run in self.steps.steps
            if run.integrator == audit.integrator and run.step <= audit.step
        )

    @property
    def errors(self) -> tuple[float, ...]:
        """Theirs [m] where the motion is known."""
        return tuple(run.at(self.steps.index) for run in self.runs)

    @property
    def holds(self) -> float | None:
        """The largest of their steps [s] that reaches the end."""
        runs = zip(self.runs, self.errors, strict=True)
        return next((run.step for run, error in runs if math.isfinite(error)), None)

    @property
    def known(self) -> float:
        """[m]: the reference resolves larger errors."""
        return RESOLVED * self.audit.uncertainty

    @property
    def resolved(self) -> tuple[float, ...]:
        """The first of their errors [m] that the reference resolves."""
        return tuple(error for error in self.errors if error > self.known)[:SHOWN]

    @property
    def ratio(self) -> float:
        """Of the errors of a step and of its half, on average."""
        return mean_ratio(self.resolved)

    @property
    def diverged(self) -> bool:
        """Whether the own step does, within the motion."""
        return bool(self.steps.own.why) and math.isinf(self.audit.error)

    @property
    def horizons(self) -> tuple[tuple[float, float | None], ...]:
        """Errors [m], and up to when [s] the most accurate step keeps them; None: to the end."""
        audit = self.audit
        ends = [(t, horizon(self.steps, audit.reference, audit.script, t)) for t in TARGETS[1:3]]
        return tuple((target, None if math.isinf(end) else end) for target, end in ends)

    @property
    def event_rate(self) -> float:
        """Contacts and limits that begin or cease to act along the reference in a second."""
        course = self.audit.reference.course
        return len(course.events) / max(course.until, self.audit.script.period)

    @property
    def better(self) -> Cheapest | None:
        """The cheapest choice for an error that is smaller than the own step's."""
        return next((c for c in self.steps.cheapest if c.target < self.audit.error), None)

    @property
    def enough(self) -> Cheapest | None:
        """The choice that saves most where the own step's error is enough."""
        audit = self.audit
        least = audit.error + audit.uncertainty
        enough = [c for c in self.steps.cheapest if c.target >= least][-1:]
        saving = (c for c in enough if c.cost is not None and c.cost.saves and audit.complete)
        return next(saving, None)

    @property
    def out_of_time(self) -> bool:
        """Whether the budget ended the reference."""
        return OUT_OF_TIME in self.audit.reference.why

    @property
    def courses(self) -> tuple[tuple[str, float, Array], ...]:
        """Integrator, step [s] and errors [m] over time, of the first halves of the step."""
        return tuple((r.integrator, r.step, _drawn(r.errors)) for r in self.runs[:COURSES])

    @property
    def uncertainty(self) -> Array:
        """Of the reference over time [m]."""
        return _drawn(self.audit.reference.uncertainty)

    @property
    def front(self) -> tuple[tuple[float, float], ...]:
        """Cost [ns per simulated second] and error [m] of runs that no other is better than."""
        points = [point for _, _, *timed in self.costs for point in zip(*timed, strict=True)]
        return front(points, lambda point: point)

    @property
    def costs(self) -> tuple[tuple[Any, ...], ...]:
        """Of each integrator the runs that reach the end: steps [s], costs [ns per simulated
        second] and errors [m]."""
        timed = groupby((run for run in self.steps.steps if run.cost), attrgetter("integrator"))
        index = self.steps.index
        rows = ((of, [(r.step, r.ns_per_second, r.at(index)) for r in runs]) for of, runs in timed)
        return tuple((of, *zip(*points, strict=True)) for of, points in rows)


def mean_ratio(errors: Sequence[float]) -> float:
    """Of each to the one before it, on average."""
    return float((errors[-1] / errors[0]) ** (1 / (len(errors) - 1)))


def _drawn(errors: Array) -> Array:
    return np.where(errors > 0.0, errors, np.nan)
