"""Verdicts on derivatives: is the error of a derivative the predicted one?"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from plumbob.engines.registry import limits_of
from plumbob.engines.study.gradient import Difference, Gradient, Gradients, GradientSearch
from plumbob.engines.study.results import Study
from plumbob.reports.judge.expectations import expected

GradientVerdict = Literal["predicted", "off-prediction", "pre-asymptotic", "unsupported"]

RESOLVED = 10.0  # multiple of the exact derivative's uncertainty: smaller errors show no order


@dataclass(frozen=True)
class JudgedGradient:
    """A derivative with its verdict, at one eps if it is a finite difference."""

    scene: str
    method: str
    gradient: Gradient
    tried: Difference | None  # the computed derivative; None: the way is unsupported
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
        return None if self.tried is None else self._relative(self.tried.computed, -1.0)

    @property
    def predicted_error(self) -> float | None:
        """The predicted relative error, signed; None without theory."""
        if self.tried is None or self.tried.predicted is None:
            return None
        return self._relative(self.tried.predicted)

    def _relative(self, value: float, more: float = 0.0) -> float | None:
        """Returns `value` divided by the exact derivative, plus `more`; None if there is no exact
        derivative, or if it is zero within its uncertainty."""
        exact = self.gradient.exact
        resolved = math.isfinite(exact) and abs(exact) > self.gradient.uncertainty
        return value / exact + more if resolved else None

    def record(self) -> dict[str, Any]:
        """The record that `plumbob gradient --json` prints."""
        of = self.gradient
        tried = self.tried
        below, above = of.one_sided or (None, None)
        return {
            "scene": self.scene,
            "method": self.method,
            "step": of.step,
            "at": of.at,
            "of": of.of,
            "by": of.by,
            "way": of.way,
            "exact": of.exact,
            "below": below,
            "above": above,
            "computed": tried and tried.computed,
            "relative_error": self.relative_error,
            "predicted_error": self.predicted_error,
            "left_open": tried and self._relative(math.copysign(tried.left_open, of.exact)),
            "eps": tried and tried.eps,
            "predicted_best_eps": of.predicted_best,
            "measured_best_eps": of.measured_best,
            "order": self.order,
            "cost": of.cost,
            "verdict": self.verdict,
            "why": self.why,
            "expected": not self.surprise,
            "known_limit": self.known,
        }


def judged_gradients(search: GradientSearch, found: Gradients) -> Iterator[JudgedGradient]:
    """Yields the judged derivatives of a search. If the user asked for values of eps, each eps
    gives one; otherwise a finite difference is judged at its best eps."""
    for gradient in found.records:
        sweep = gradient.tried and not search.eps
        tried = (gradient.best,) if sweep else gradient.tried
        for difference in tried or (None,):
            yield _judged(search, gradient, difference)


def _judged(search: GradientSearch, of: Gradient, tried: Difference | None) -> JudgedGradient:
    """Returns a derivative with its verdict, compared with the known limits of the method."""
    verdict, why = _verdict(of, tried)
    pair = search.scene, search.method
    known = None if search.changes else limits_of(search.method).gradient(pair, of.by, of.way)
    # If the error of the run is a known limit, the error of the derivative is one too.
    run = expected(*pair)
    off = verdict == "off-prediction"
    reason = ""
    judged = JudgedGradient(*pair, of, tried, verdict, why)
    if known is None:
        reason = run.reason if run.limit and off else ""
        return replace(judged, surprise=why if off and not reason else "", known=reason)
    surprise = "predicted, expected off-prediction" if verdict == "predicted" else ""
    error = abs(judged.relative_error or 0.0)
    factor = known.factor
    if off and not known.size / factor <= error <= known.size * factor:
        within = f"within a factor of {factor:g}"
        surprise = f"its error is {error:.3g}, and known to be {known.size:g}, {within}"
    reason = known.reason if verdict != "unsupported" else ""
    return replace(judged, surprise=surprise, known=reason)


def _verdict(of: Gradient, tried: Difference | None) -> tuple[GradientVerdict, str]:
    """Returns the verdict on a derivative, and its reason. The error may differ from the predicted
    error, to either side, by no more than theory leaves open."""
    if tried is None:
        return "unsupported", of.why
    if of.no_exact:
        return "pre-asymptotic", f"there is no derivative: {of.no_exact}"
    if tried.predicted is None:
        return "pre-asymptotic", "there is no theory of its error"
    off = abs(tried.computed - of.exact - tried.predicted)
    allowed = tried.left_open + of.uncertainty
    if tried.left_open > abs(of.exact) > of.uncertainty:
        return "pre-asymptotic", f"{tried.left_open:.3g} is left open, more than the derivative"
    if off <= allowed:
        return "predicted", ""
    return "off-prediction", f"{off:.3g} off its prediction, allowed {allowed:.3g}"


def study_gradients(study: Study) -> Iterator[JudgedGradient]:
    """Yields the judged derivatives of a study; those at several steps have their order. A search
    whose engine is missing, or whose process was lost, has none."""
    judged = [
        of
        for request in study.extras
        if isinstance(request, GradientSearch) and (found := study.answer(request))
        for of in judged_gradients(request, found)
    ]
    errors: dict[tuple[str, ...], dict[float, float]] = {}
    for of in judged:
        errors.setdefault(_pair(of), {}).setdefault(of.gradient.step, _of_runs(of))
    return (replace(of, order=_order(errors[_pair(of)])) for of in judged)


def _pair(of: JudgedGradient) -> tuple[str, ...]:
    """The key of a derivative without its step: scene, method and derivative."""
    return of.scene, of.method, of.about


def _of_runs(of: JudgedGradient) -> float:
    """Returns the magnitude of the part of a derivative's error that the runs cause, without the
    truncation of the finite difference. NaN if it is not known."""
    tried = of.tried
    known = of.gradient
    if tried is None:
        return math.nan
    error = abs(tried.computed - known.exact - tried.truncation)
    return error if error > RESOLVED * known.uncertainty else math.nan


def _order(errors: Mapping[float, float]) -> float | None:
    """Returns the slope of log error against log step; None at a single step, or if an error is not
    known."""
    steps = np.log(list(errors))
    sizes = np.log(list(errors.values()))
    if len(steps) < 2 or not np.isfinite(sizes).all():
        return None
    return float(np.polyfit(steps, sizes, 1)[0])
