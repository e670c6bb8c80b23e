"""Verdicts on derivatives: is the error of a derivative the predicted one?"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from plumbob.engines.registry import limits_of
from plumbob.engines.study.gradient import Gradient, Gradients, GradientSearch, TriedDifference
from plumbob.engines.study.results import Study
from plumbob.reports.judge.expectations import expected

GradientVerdict = Literal["predicted", "off-prediction", "pre-asymptotic", "unsupported"]

# multiple of the exact derivative's uncertainty: smaller errors show no order
RESOLVED_MULTIPLE = 10.0


@dataclass(frozen=True)
class JudgedGradient:
    """A derivative with its verdict, at one eps if it is a finite difference."""

    scene: str
    method: str
    gradient: Gradient
    # the computed derivative; None if the method has no such derivative
    tried: TriedDifference | None
    verdict: GradientVerdict
    why: str = ""
    surprise: str = ""  # why the verdict is not as expected
    known: str = ""  # the reason of a known limit
    order: float | None = None  # order of the error over several steps, if there are several

    @property
    def about(self) -> str:
        """Name of the derivative: the way, the quantity and the parameter."""
        return f"{self.gradient.way}, {self.gradient.of} by {self.gradient.by}"

    @property
    def relative_error(self) -> float | None:
        """The signed relative error; None if there is no exact derivative, or if it is zero within
        its uncertainty."""
        if self.tried is None:
            return None
        ratio = self._relative(self.tried.computed)
        return None if ratio is None else ratio - 1.0

    @property
    def predicted_error(self) -> float | None:
        """The predicted relative error, signed; None without theory."""
        if self.tried is None or self.tried.predicted is None:
            return None
        return self._relative(self.tried.predicted)

    def _relative(self, value: float) -> float | None:
        """Returns `value` divided by the exact derivative; None if there is no exact derivative, or
        if it is zero within its uncertainty."""
        exact = self.gradient.exact
        if not math.isfinite(exact) or abs(exact) <= self.gradient.uncertainty:
            return None
        # Adding zero turns -0.0 into 0.0.
        return value / exact + 0.0

    def record(self) -> dict[str, Any]:
        """The record that `plumbob gradient --json` prints."""
        gradient = self.gradient
        tried = self.tried
        below, above = gradient.one_sided or (None, None)
        left_open = None
        if tried is not None:
            left_open = self._relative(math.copysign(tried.left_open, gradient.exact))
        return {
            "scene": self.scene,
            "method": self.method,
            "step": gradient.step,
            "at": gradient.at,
            "of": gradient.of,
            "by": gradient.by,
            "way": gradient.way,
            "exact": gradient.exact,
            "below": below,
            "above": above,
            "computed": tried and tried.computed,
            "relative_error": self.relative_error,
            "predicted_error": self.predicted_error,
            "left_open": left_open,
            "eps": tried and tried.eps,
            "predicted_best_eps": gradient.predicted_best,
            "measured_best_eps": gradient.measured_best,
            "order": self.order,
            "cost": gradient.cost,
            "verdict": self.verdict,
            "why": self.why,
            "expected": not self.surprise,
            "known_limit": self.known,
        }


def judged_gradients(search: GradientSearch, gradients: Gradients) -> Iterator[JudgedGradient]:
    """Yields the judged derivatives of a search. If the user asked for values of eps, a finite
    difference is judged at each of them; otherwise it is judged at its best eps. A derivative that
    is no finite difference is judged once."""
    for gradient in gradients.records:
        only_best = gradient.tried and not search.eps
        differences = (gradient.best,) if only_best else gradient.tried
        for difference in differences or (None,):
            yield _judged_gradient(search, gradient, difference)


def _judged_gradient(
    search: GradientSearch, gradient: Gradient, tried: TriedDifference | None
) -> JudgedGradient:
    """Returns a derivative with its verdict, compared with the known limits of the method."""
    pair = search.scene, search.method
    verdict, why = _gradient_verdict(gradient, tried)
    judged = JudgedGradient(*pair, gradient, tried, verdict, why)
    off_prediction = verdict == "off-prediction"
    known = None
    if not search.changes:
        known = limits_of(search.method).gradient(pair, gradient.by, gradient.way)
    if known is None:
        if not off_prediction:
            return judged
        # If the error of the run is a known limit, the error of the derivative is one too.
        run_expectation = expected(*pair)
        reason = run_expectation.reason if run_expectation.limit else ""
        return replace(judged, surprise="" if reason else why, known=reason)
    surprise = ""
    error = abs(judged.relative_error or 0.0)
    factor = known.factor
    if verdict == "predicted":
        surprise = "predicted, expected off-prediction"
    elif off_prediction and not known.size / factor <= error <= known.size * factor:
        within = f"within a factor of {factor:g}"
        surprise = f"its error is {error:.3g}, and known to be {known.size:g}, {within}"
    reason = known.reason if verdict != "unsupported" else ""
    return replace(judged, surprise=surprise, known=reason)


def _gradient_verdict(
    gradient: Gradient, tried: TriedDifference | None
) -> tuple[GradientVerdict, str]:
    """Returns the verdict on a derivative, and its reason. The error may differ from the predicted
    error, to either side, by no more than theory leaves open."""
    if tried is None:
        return "unsupported", gradient.why
    if gradient.no_exact:
        return "pre-asymptotic", f"there is no derivative: {gradient.no_exact}"
    if tried.predicted is None:
        return "pre-asymptotic", "there is no theory of its error"
    if tried.left_open > abs(gradient.exact) > gradient.uncertainty:
        reason = f"theory leaves {tried.left_open:.3g} open, more than the derivative itself"
        return "pre-asymptotic", reason
    difference = abs(tried.computed - gradient.exact - tried.predicted)
    allowed = tried.left_open + gradient.uncertainty
    if difference <= allowed:
        return "predicted", ""
    return "off-prediction", f"{difference:.3g} from its prediction, allowed {allowed:.3g}"


def study_gradients(study: Study) -> Iterator[JudgedGradient]:
    """Yields the judged derivatives of a study; those at several steps have their order. A search
    whose engine is missing, or whose process was lost, has none."""
    judged: list[JudgedGradient] = []
    for request in study.extras:
        if not isinstance(request, GradientSearch):
            continue
        gradients = study.answer(request)
        if gradients:
            judged += judged_gradients(request, gradients)
    errors: dict[tuple[str, ...], dict[float, float]] = {}
    for derivative in judged:
        errors_by_step = errors.setdefault(_derivative_key(derivative), {})
        errors_by_step.setdefault(derivative.gradient.step, _run_error(derivative))
    for derivative in judged:
        order = _error_order(errors[_derivative_key(derivative)])
        yield replace(derivative, order=order)


def _derivative_key(derivative: JudgedGradient) -> tuple[str, ...]:
    """The key of a derivative without its step: scene, method and derivative."""
    return derivative.scene, derivative.method, derivative.about


def _run_error(derivative: JudgedGradient) -> float:
    """Returns the magnitude of the part of a derivative's error that the runs cause, without the
    truncation of the finite difference. NaN if it is not known."""
    tried = derivative.tried
    gradient = derivative.gradient
    if tried is None:
        return math.nan
    error = abs(tried.computed - gradient.exact - tried.truncation)
    return error if error > RESOLVED_MULTIPLE * gradient.uncertainty else math.nan


def _error_order(errors: Mapping[float, float]) -> float | None:
    """Returns the slope of log error against log step; None at a single step, or if an error is not
    known."""
    log_steps = np.log(list(errors))
    log_errors = np.log(list(errors.values()))
    if len(log_steps) < 2 or not np.isfinite(log_errors).all():
        return None
    return float(np.polyfit(log_steps, log_errors, 1)[0])
