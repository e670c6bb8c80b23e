"""The figures of an audit's answer that its template needs beside the audit itself."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.reference import OUT_OF_TIME, RESOLVED
from plumbob.engines.audit.stability import Limit
from plumbob.engines.audit.step_errors import TARGETS, Cheapest, Compared, StepError, horizon
from plumbob.reports.advice.work_precision import front

NOTICED = 1e-6  # [m]: a smaller error at an earlier time is not mentioned
SHOWN = 5  # errors of a halving
COURSES = 4  # steps of the own integrator in the figure over time


@dataclass(frozen=True)
class Halving:
    """The own integrator at the own step and halves of it."""

    steps: tuple[float, ...]  # [s]
    errors: tuple[float, ...]  # [m]
    known: float  # [m]: the reference resolves larger errors
    uncertainty: float  # [m]

    @property
    def diverges(self) -> bool:
        """Whether the own step does."""
        return math.isinf(self.errors[0])

    @property
    def holds(self) -> float | None:
        """The largest step [s] that reaches the end."""
        runs = zip(self.steps, self.errors, strict=True)
        return next((step for step, error in runs if math.isfinite(error)), None)

    @property
    def resolved(self) -> tuple[float, ...]:
        """The first errors [m] that the reference resolves."""
        return tuple(error for error in self.errors if error > self.known)[:SHOWN]

    @property
    def most(self) -> float | None:
        """The largest error [m] that the first half of the step may have."""
        return self.errors[1] + self.uncertainty if len(self.errors) > 1 else None

    @property
    def ratio(self) -> float:
        """Of the errors of a step and of its half, on average."""
        errors = self.resolved
        return float((errors[-1] / errors[0]) ** (1 / (len(errors) - 1)))


@dataclass(frozen=True)
class Choice:
    """An integrator and a step to choose, and the file's options that set them."""

    best: Cheapest
    options: Mapping[str, tuple[str, str]]  # what each is, and what to put in its place


@dataclass(frozen=True)
class Costs:
    """Runs of an integrator: the cost [ns per simulated second] and the error [m] of each step."""

    integrator: str
    steps: tuple[float, ...]  # [s]
    costs: tuple[float, ...]
    errors: tuple[float, ...]


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
    def halving(self) -> Halving:
        """Their errors where the motion is known."""
        uncertainty = self.audit.uncertainty
        return Halving(
            tuple(run.step for run in self.runs),
            tuple(run.at(self.steps.index) for run in self.runs),
            RESOLVED * uncertainty,
            uncertainty,
        )

    @property
    def earlier(self) -> tuple[float, float] | None:
        """The last error [m] that the reference resolves, where it is noticed, and its time [s]."""
        index = self.audit.resolved_index
        error = self.steps.own.at(index)
        return (error, self.audit.script.times[index]) if index and error > NOTICED else None

    @property
    def diverged(self) -> bool:
        """Whether the own step does, within the motion."""
        return bool(self.steps.own.why) and math.isinf(self.audit.error)

    @property
    def horizons(self) -> tuple[tuple[float, float | None], ...]:
        """Errors [m], and up to when [s] the own step stays within each; None: to the end."""
        audit = self.audit
        ends = [(t, horizon(self.steps, audit.reference, audit.script, t)) for t in TARGETS[1:3]]
        return tuple((target, None if math.isinf(end) else end) for target, end in ends)

    @property
    def other_limits(self) -> tuple[tuple[str, Limit], ...]:
        """Limits of the step of integrators that are not the model's own, with the names of those
        that have the same."""
        assert self.audit.stability is not None
        limits = self.audit.stability.limits[1:]
        firsts = {(limit.confirmed, limit.largest_step): limit for limit in reversed(limits)}
        names = {
            key: ", ".join(n.integrator for n in limits if (n.confirmed, n.largest_step) == key)
            for key in reversed(firsts)
        }
        return tuple((names[key], firsts[key]) for key in names)

    @property
    def events(self) -> int:
        """Contacts and limits that begin or cease to act along the reference."""
        return len(self.audit.reference.course.events)

    @property
    def event_rate(self) -> float:
        """The same in a second."""
        return self.events / max(self.audit.reference.course.until, self.audit.script.period)

    @property
    def better(self) -> Choice | None:
        """The cheapest choice for an error that is smaller than the own step's."""
        return self._choice([c for c in self.steps.cheapest if c.target < self.audit.error][:1])

    @property
    def enough(self) -> Choice | None:
        """The choice that saves most where the own step's error is enough."""
        audit = self.audit
        least = audit.error + audit.uncertainty
        enough = [c for c in self.steps.cheapest if c.target >= least][-1:]
        saves = any(c.cost is not None and c.cost.saves for c in enough)
        return self._choice(enough) if saves and audit.complete else None

    def _choice(self, cheapest: Sequence[Cheapest]) -> Choice | None:
        assert self.audit.model is not None
        option = self.audit.model.option
        return next((Choice(best, option(best.integrator, best.step)) for best in cheapest), None)

    @property
    def nearer(self) -> bool:
        """Whether a smaller error than the own step's was wanted."""
        return min(TARGETS) < self.audit.error

    @property
    def out_of_time(self) -> bool:
        """Whether the budget ended the reference."""
        return OUT_OF_TIME in self.audit.reference.why

    @property
    def courses(self) -> tuple[tuple[str, float, Array], ...]:
        """Integrator, step [s] and errors [m] over time, of the first halves of the step."""
        return tuple((r.integrator, r.step, _drawn(r.errors)) for r in self.runs[:COURSES])

    @property
    def known(self) -> Array:
        """The uncertainty of the reference over time [m]."""
        return _drawn(self.audit.reference.uncertainty)

    @property
    def costs(self) -> tuple[Costs, ...]:
        """The runs by integrator."""
        runs: dict[str, list[tuple[float, float, float]]] = {}
        for ns, error, run in self._points():
            runs.setdefault(run.integrator, []).append((run.step, ns, error))
        return tuple(Costs(name, *zip(*rows, strict=True)) for name, rows in runs.items())

    @property
    def front(self) -> tuple[tuple[float, float], ...]:
        """Cost and error of the runs that no other is better than."""
        return tuple((ns, error) for ns, error, _ in front(self._points(), lambda p: p[:2]))

    def _points(self) -> list[tuple[float, float, StepError]]:
        return [
            (ns, run.at(self.steps.index), run)
            for run in self.steps.steps
            if (ns := run.ns_per_second) is not None
        ]

    @property
    def paces(self) -> tuple[tuple[float, ...], ...]:
        """Processor time over simulated time of each run, with its quartiles; none where it
        ended early."""
        costs = [(run.cost, run.step) for run in self.steps.steps]
        return tuple(
            tuple(1e-9 * ns / step for ns in (c.ns_per_step, c.low, c.high)) if c else ()
            for c, step in costs
        )


def _drawn(errors: Array) -> Array:
    return np.where(errors > 0.0, errors, np.nan)
