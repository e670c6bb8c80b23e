"""Results of methods on scenes as pages show them: errors by step, their meaning and the largest
accurate and stable steps."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import takewhile
from types import MappingProxyType
from typing import Literal

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import DEFAULT, ConvergenceStudy, timed_run
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.measurement import (
    REFERENCE_STEP,
    Measurement,
    floor,
    reference_run,
    relative_error,
    worst,
)
from plumbob.engines.study.order import order_and_prediction
from plumbob.engines.study.results import Quantities, Study
from plumbob.engines.study.stability import SmallestLimit
from plumbob.models.scene import Quantity, Scene
from plumbob.reports.advice.recommend import UNTRUSTED
from plumbob.reports.records import notation
from plumbob.reports.records.page_records import PairVerdict, Records
from plumbob.reports.view.palette import size_class

Meaning = Literal["predicted", "converges", "limit", "unexpected", "unclaimed", "not-run"]
# Meanings of results whose errors are as expected of the method
TRUSTED_MEANINGS: tuple[Meaning, ...] = ("predicted", "converges")
SIGNS: Mapping[Meaning, tuple[str, str, str]] = MappingProxyType(
    {
        "predicted": (
            "=",
            "as predicted",
            "the error is the predicted one, or within its bound",
        ),
        "converges": ("↓", "converges", "not predicted, but smaller steps remove it"),
        "limit": ("◆", "known limit", "declared, with its reason and its size"),
        "unclaimed": ("?", "step too large", "the theory does not reach it"),
        "unexpected": ("✗", "unexpected", "not what theory or a declared limit says"),
    }
)
LARGEST_STEP = DEFAULT[1]  # [s] MuJoCo's default step
LOOSEST = 1e-3  # scipy's default relative tolerance
PERCENT = 0.01  # largest relative error of an accurate step


@dataclass(frozen=True)
class ShownError:
    """The error of a method on a scene, with the step at which it was measured."""

    error: float  # relative; infinite where the run diverged
    step: float  # [s], or the relative tolerance
    control: Literal["step", "tolerance"]
    meaning: Meaning = "predicted"

    @property
    def text(self) -> str:
        """The error as text, followed by its step unless that is the reference step."""
        at = self._beside(REFERENCE_STEP)
        return f"{self._size} at {at}" if at else self._size

    def cell(self, column: float | None) -> str:
        """Returns the sign of the meaning and the error as text, followed by the step unless that
        is the step of the column [s]."""
        at = self._beside(column)
        return f"{SIGNS[self.meaning][0]} {self._size}" + (f"\n{at}" if at else "")

    @property
    def look(self) -> str:
        """The CSS classes of a table cell: the decade of the error, and `unexpected` if it is."""
        return size_class(self.error) + " unexpected" * (self.meaning == "unexpected")

    @property
    def _size(self) -> str:
        """The error as text; "diverged" if it is infinite."""
        return "diverged" if math.isinf(self.error) else notation.relative(self.error)

    def _beside(self, column: float | None) -> str:
        """Returns the step as text; empty if it is the step of the column [s]."""
        if self.control == "step" and column and math.isclose(self.step, column, rel_tol=1e-9):
            return ""
        return notation.step(self.step, self.control)


@dataclass(frozen=True)
class ErrorWithOrder(ShownError):
    """The error of a method at one step, at the end or the largest on the way, with the order in
    the step that its runs show and the order that theory predicts for the same runs."""

    order: float | None = None  # None if it cannot be fitted, or the method has no step
    predicted_order: float | None = None  # None if theory predicts no error of one of the runs


@dataclass(frozen=True)
class MethodResult:
    """The result of one method on one scene: its runs, its verdict, the cost of a step and, for a
    method with a fixed step, its largest stable step."""

    scene: Scene
    method: Method
    series: ConvergenceStudy
    judged: PairVerdict
    quantities: Quantities  # quantities of interest of the scene
    cost: Cost | None = None
    limit: SmallestLimit | None = None

    @property
    def name(self) -> str:
        """The method's name."""
        return self.method.name

    @cached_property
    def done(self) -> Sequence[Measurement]:
        """The runs that reached their end, coarse to fine."""
        return [m for m in self.series.measurements if m.status == "done"]

    @cached_property
    def errors(self) -> Mapping[float, float]:
        """Relative error of each run by its step; infinite if the run diverged."""
        runs = [m for m in self.series.measurements if m.status in ("done", "diverged")]
        return {run.step: relative_error(run, self.quantities) for run in runs}

    @property
    def meaning(self) -> Meaning:
        """The verdict's meaning to a reader."""
        verdict = self.judged.verdict
        if self.judged.mark == "unexpected":
            return "unexpected"
        if verdict in ("unsupported", "missing"):
            return "not-run"
        if self.judged.mark == "known" or verdict in UNTRUSTED:
            return "limit"
        if verdict == "pre-asymptotic":
            return "unclaimed"
        return "converges" if verdict == "converges" else "predicted"

    @property
    def reference(self) -> Measurement | None:
        """The run whose step is nearest to the reference step."""
        return reference_run(self.series.measurements, self.method)

    def worst(self, run: Measurement) -> tuple[Quantity, float]:
        """Returns the quantity of interest with the largest relative error in `run`, and that
        error."""
        return worst(run, self.quantities)

    @cached_property
    def at_reference(self) -> ShownError | None:
        """The error at the reference step; None if nothing was run.

        If the reference step was not run, this is the error at the nearest step, or at the tightest
        tolerance."""
        run = self.reference
        step = run.step if run else next(reversed(self.errors), None)
        if self.method.control == "step" and REFERENCE_STEP in self.errors:
            step = REFERENCE_STEP
        if step is None or math.isnan(self.errors[step]) or self.meaning == "not-run":
            return None
        return self._at(step)

    @property
    def at_end(self) -> ErrorWithOrder | None:
        """The error at the end of the run at the reference step, the largest of all quantities of
        interest, with its orders; None if nothing was run."""
        return self._with_order("end")

    @property
    def on_the_way(self) -> ErrorWithOrder | None:
        """The largest error over the run at the reference step and over all quantities of interest,
        with its orders; None if nothing was run."""
        return self._with_order("run")

    def _with_order(self, when: Literal["end", "run"]) -> ErrorWithOrder | None:
        """Returns the error at the reference step, taken at the end or over the run, with its
        orders; None if nothing was run."""
        shown = self.at_reference
        if shown is None:
            return None
        quantities = [replace(quantity, when=when) for quantity in self.quantities]
        error = shown.error
        if not math.isinf(error):
            run = next(run for run in self.done if run.step == shown.step)
            error = relative_error(run, quantities)
        orders = self._orders(quantities) if self.method.control == "step" else (None, None)
        return ErrorWithOrder(
            error, shown.step, shown.control, shown.meaning, orders[0], orders[1]
        )

    def _orders(self, quantities: Sequence[Quantity]) -> tuple[float | None, float | None]:
        """Returns the observed and the predicted order of the relative error of `quantities`. A run
        that lacks one of the quantities does not count, nor does a run beside the step sizes."""
        rows = []
        for run in self.done:
            error = relative_error(run, quantities)
            if run.step not in self.series.beside and math.isfinite(error):
                rows.append(
                    (
                        run.step,
                        error,
                        _largest_floor(run, quantities),
                        _predicted_error(run, quantities),
                    )
                )
        return order_and_prediction(*zip(*rows, strict=True)) if rows else (None, None)

    @property
    def largest_at_reference(self) -> ShownError | None:
        """The largest error at the reference step and at all smaller steps that were run; None if
        nothing was run. An error that crosses zero is small at one step by chance."""
        shown = self.at_reference
        if shown is None or self.method.control != "step":
            return shown
        smaller = [error for step, error in self.errors.items() if step <= shown.step]
        return replace(shown, error=max(error for error in smaller if not math.isnan(error)))

    @property
    def at_default(self) -> ShownError:
        """The error of the run nearest to the default settings. These are MuJoCo's default
        step and, for a method that is controlled by a tolerance, scipy's default tolerance."""
        default = LARGEST_STEP if self.method.control == "step" else LOOSEST
        nearest = min(self.errors, key=lambda step: abs(math.log(step / default)))
        return self._at(nearest)

    @property
    def at_largest(self) -> ShownError | None:
        """The error at the largest accurate step."""
        return self._at(self.accurate) if self.accurate else None

    @property
    def finest(self) -> ShownError | None:
        """The error at the smallest step that reached the end."""
        return self._at(self.done[-1].step) if self.done else None

    def at_a_tenth(self, step: float) -> ShownError | None:
        """Returns the error at a tenth of a step [s]; None if that step was not run."""
        same = [s for s in self.errors if math.isclose(10.0 * s, step, rel_tol=1e-9)]
        return self._at(same[0]) if same else None

    def _at(self, step: float) -> ShownError:
        """Returns the error at a step. Its meaning is "unclaimed" if the verdict on the method is
        as predicted, but this step is too large for the theory."""
        runs = zip(self.series.measurements, self.judged.runs, strict=False)
        verdicts = {run.step: judged.verdict for run, judged in runs}
        too_large = verdicts.get(step) in ("pre-asymptotic", "diverged")
        meaning: Meaning = self.meaning
        if too_large and meaning == "predicted":
            meaning = "unclaimed"
        return ShownError(self.errors[step], step, self.method.control, meaning)

    @cached_property
    def accurate(self) -> float | None:
        """The largest step [s], or tolerance, whose error and the errors of all smaller steps are
        at most 1 %; None if the smallest step is less accurate."""
        within = [*takewhile(lambda step: self.errors[step] <= PERCENT, sorted(self.errors))]
        return within[-1] if within else None

    @property
    def margin(self) -> float | None:
        """The ratio of the largest stable step to the largest accurate step; None if either is
        unknown or stability sets no limit."""
        if self.limit is None or not self.accurate or math.isinf(self.limit.step):
            return None
        return self.limit.step / self.accurate

    @property
    def limited_by(self) -> str:
        """The reason that the largest accurate step is not larger: `stability` if the next step run
        is unstable, else `accuracy`; empty if that is not known."""
        larger = [step for step in self.errors if step > (self.accurate or 0.0)]
        if self.limit is None or not larger:
            return ""
        next_unstable = self.accurate is not None and min(larger) > self.limit.step
        return "stability" if next_unstable or not self.limit.step else "accuracy"

    def ns_per_second(self, step: float) -> float | None:
        """Returns the computing time [ns] of a simulated second at `step`; None if no run with this
        step reached its end, or nothing was timed."""
        runs = [run for run in self.done if run.step == step and run.duration]
        if not runs or not self.cost:
            return None
        return runs[0].steps * self.cost.ns_per_step / runs[0].duration

    @property
    def timed(self) -> Measurement | None:
        """The run whose step is the one at which the cost was measured."""
        return timed_run(self.series, self.method)

    @property
    def in_reach(self) -> bool:
        """Whether the error expansion is valid (nonlinearity below 1) for every error that the
        order was fitted to."""
        steps = self.series.order.steps if self.series.order else ()
        fitted = [run for run in self.done if run.step in steps]
        predicted = [error.predicted for run in fitted for error in run.errors.values()]
        return all(p is not None and p.nonlinearity < 1.0 for p in predicted)


def _largest_floor(run: Measurement, quantities: Sequence[Quantity]) -> float:
    """Returns the largest round-off level of the quantities of interest, relative to their
    scales."""
    return max(floor(run.errors[q.observable], run.steps) / q.scale for q in quantities)


def _predicted_error(run: Measurement, quantities: Sequence[Quantity]) -> float:
    """Returns the predicted relative error of a run, the largest of the quantities of interest; NaN
    if theory predicts no error of one of them, or its series does not reach the step."""
    sizes = []
    for quantity in quantities:
        predicted = run.errors[quantity.observable].predicted
        if predicted is None or predicted.nonlinearity >= 1.0:
            return math.nan
        size = abs(predicted.end) if quantity.when == "end" else predicted.largest
        sizes.append(size / quantity.scale)
    return max(sizes)


Results = Mapping[tuple[str, str], MethodResult]  # by the names of scene and method


def results_of(study: Study, records: Records) -> Results:
    """Returns the results of every method on every scene of `study`."""
    methods = {m.name: m for m in study.methods}
    scenes = {s.name: s for s in study.scenes}
    results = {}
    for series in study.convergence:
        pair = (series.scene, series.method)
        method = methods[series.method]
        results[pair] = MethodResult(
            scene=scenes[series.scene],
            method=method,
            series=series,
            judged=records.scenes[series.scene].verdicts[series.method],
            quantities=study.quantities(series.scene),
            cost=study.costs.get(pair),
            limit=study.step_limit(*pair) if method.control == "step" else None,
        )
    return results


def finite_limits(results: Sequence[MethodResult]) -> dict[str, float]:
    """Returns the largest stable step [s] of each method whose limit is positive and finite."""
    limits = {result.name: result.limit.step for result in results if result.limit}
    return {name: step for name, step in limits.items() if 0.0 < step < math.inf}
