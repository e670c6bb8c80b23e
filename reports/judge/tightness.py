"""Tolerances relative to the error and to the motion."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from sys import float_info

import numpy as np

from plumbob.analytic.left_open import roundings
from plumbob.engines.study.measurement import Measurement, ObservedError
from plumbob.engines.study.results import Study
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.judge.tolerance import Tolerance

ROUND_OFFS = 10.0  # a difference of so many round-offs says nothing of what theory leaves open


@dataclass(frozen=True)
class Slack:
    """The tolerance of one run for one observable, in its unit."""

    method: str
    scene: str
    observable: str
    step: float  # [s], or the relative tolerance of an adaptive method
    allowed: float  # of measured less predicted, or of the error where nothing is predicted
    used: float  # the same, as it is
    round_off: float  # what rounding alone may do
    scale: float  # largest magnitude of the exact observable
    bound_only: bool  # the error has a bound and no prediction, as that of an adaptive method

    @property
    def rounded(self) -> bool:
        """Whether rounding alone may be most of the difference."""
        return self.used <= ROUND_OFFS * self.round_off

    @property
    def over_use(self) -> float:
        """Allowed over used."""
        return self.allowed / self.used

    @property
    def over_scale(self) -> float | None:
        """Allowed over the motion's scale; None where the exact observable stays zero."""
        return self.allowed / self.scale if self.scale > 0.0 else None


@dataclass(frozen=True)
class Spread:
    """Median, 90 % and largest of some ratios."""

    median: float
    most: float
    worst: float


@dataclass(frozen=True)
class Tightness:
    """How tight the tolerances of a method are, over all runs that pass and all observables."""

    method: str
    bound_only: bool
    held: int  # values
    rounded: int  # of these those that rounding alone may make, which are left out of `over_use`
    over_use: Spread | None  # allowed over actual
    over_scale: Spread | None  # allowed over motion


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


def spread(ratios: Sequence[float]) -> Spread | None:
    """The spread of some ratios; None where there are none."""
    if not ratios:
        return None
    median, most = np.quantile(ratios, [0.5, 0.9])
    return Spread(float(median), float(most), float(np.max(ratios)))


def tightness(every: Iterable[Slack]) -> tuple[Tightness, ...]:
    """How tight tolerances are, by method: those of predictions, and bounds alone."""
    by_method: dict[tuple[str, bool], list[Slack]] = {}
    for slack in every:
        by_method.setdefault((slack.method, slack.bound_only), []).append(slack)
    return tuple(_tightness(*key, of) for key, of in by_method.items())


def _tightness(method: str, bound_only: bool, of: Sequence[Slack]) -> Tightness:
    telling = [slack.over_use for slack in of if not slack.rounded]
    over_scale = [ratio for slack in of if (ratio := slack.over_scale) is not None]
    rounded = len(of) - len(telling)
    return Tightness(method, bound_only, len(of), rounded, spread(telling), spread(over_scale))


def _slack(run: Measurement, name: str, held: Tolerance) -> Slack:
    error = run.errors[name]
    predicted = error.predicted
    allowed, used = held.bound, error.largest
    if predicted and error.left_open is not None:
        allowed, used = error.left_open, predicted.difference
    return Slack(
        run.method,
        run.scene,
        name,
        run.step,
        allowed,
        used,
        _round_off(error, run.steps),
        error.scale,
        predicted is None,
    )


def _round_off(error: ObservedError, steps: int) -> float:
    """Of an observable that stays zero, which rounds to nothing: one in the last place of its
    unit."""
    unit = 0.0 if error.scale > 0.0 else float_info.epsilon
    return max(error.uncertainty, unit) * roundings(steps)
