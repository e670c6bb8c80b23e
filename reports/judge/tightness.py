"""Tolerances relative to the error and to the motion."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from sys import float_info

import numpy as np

from plumbob.analytic.left_open import roundings
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Study
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.judge.tolerance import Tolerance

ROUND_OFFS = 10.0  # a difference of so many round-offs says nothing of what theory leaves open
Spread = tuple[float, float, float]  # median, 90 % and largest of some ratios


@dataclass(frozen=True)
class Slack:
    """The tolerance of one run for one observable, in its unit."""

    method: str
    scene: str
    observable: str
    step: float  # [s], or the relative tolerance of an adaptive method
    allowed: float  # of measured less predicted, or of the error where nothing is predicted
    used: float  # the same, as it is
    rounded: bool  # rounding alone may be most of that
    scale: float  # largest magnitude of the exact observable
    bound_only: bool  # the error has a bound and no prediction, as that of an adaptive method


@dataclass(frozen=True)
class Tightness:
    """How tight the tolerances of a method are, over all runs that pass and all observables."""

    method: str
    bound_only: bool
    held: int  # values
    rounded: int  # of these those that rounding alone may make, which are left out of `over_use`
    over_use: Spread | None  # allowed over actual
    over_scale: Spread | None  # allowed over motion, where the exact observable is not zero


@dataclass(frozen=True)
class Noticed:
    """The smallest change of a parameter that is noticed, and in which run and observable."""

    change: float  # relative to the parameter; in its SI unit where that is zero
    step: float
    observable: str


def slacks(study: Study, judged: Judgements) -> Iterator[Slack]:
    """Every observable that is held to a tolerance in a run that passes."""
    for c in study.convergence:
        for run, verdict in zip(c.measurements, judged[c.scene, c.method].runs, strict=True):
            if verdict.verdict == "predicted":
                for name, held in verdict.tolerances.items():
                    yield _slack(run, name, held)


def tightness(every: Iterable[Slack]) -> tuple[Tightness, ...]:
    """How tight tolerances are, by method: those of predictions, and bounds alone."""
    by_method: dict[tuple[str, bool], list[Slack]] = {}
    for slack in every:
        by_method.setdefault((slack.method, slack.bound_only), []).append(slack)
    return tuple(
        Tightness(
            *key,
            len(of),
            sum(slack.rounded for slack in of),
            _spread([slack.allowed / slack.used for slack in of if not slack.rounded]),
            _spread([slack.allowed / slack.scale for slack in of if slack.scale > 0.0]),
        )
        for key, of in by_method.items()
    )


def _spread(ratios: list[float]) -> Spread | None:
    if not ratios:
        return None
    median, most = np.quantile(ratios, [0.5, 0.9])
    return float(median), float(most), max(ratios)


def _slack(run: Measurement, name: str, held: Tolerance) -> Slack:
    error = run.errors[name]
    predicted, allowed, used = error.predicted, held.bound, error.largest
    if predicted and error.left_open is not None:
        allowed, used = error.left_open, predicted.difference
    # An observable that stays zero rounds to nothing: it has one in the last place of its unit.
    unit = 0.0 if error.scale > 0.0 else float_info.epsilon
    rounded = used <= ROUND_OFFS * max(error.uncertainty, unit) * roundings(run.steps)
    about = run.method, run.scene, name, run.step
    return Slack(*about, allowed, used, rounded, error.scale, predicted is None)
