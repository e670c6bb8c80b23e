"""Mean returns of episodes at several steps: differences by pairs with their intervals, and the
limit of small steps.

Beyond the horizon of a chaotic motion two runs part, and means over many starts still converge with
the step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from plumbob.analytic.reference import Array

CONFIDENCE = 0.95  # confidence of all intervals
HALVED = (1, 2, 4)  # divisors of the model's own step: the quotients are run
# Largest relative difference of a change from that of its order: a term of the next order is then
# a small part of the error
OFF_ORDER = 0.5
RESAMPLES = 2000  # resamples of a bootstrap
# Order of the errors of means at small steps, by integrator; others are of first order
ORDERS = MappingProxyType({"rk4": 4})


@dataclass(frozen=True)
class MeanInterval:
    """A mean over episodes with its 95 % interval, by Student's t of the pairs, and beside it the
    interval by bootstrap."""

    mean: float
    low: float
    high: float
    bootstrap_low: float
    bootstrap_high: float

    @property
    def half(self) -> float:
        """Half the width of the interval."""
        return (self.high - self.low) / 2

    @property
    def resolved(self) -> bool:
        """Whether the interval excludes zero."""
        return self.low > 0.0 or self.high < 0.0


@dataclass(frozen=True)
class StepReturn:
    """The returns at one step of an integrator, and by how much they differ from those at the
    model's own integrator and step, from the same starts."""

    integrator: str
    step: float  # [s]
    mean: MeanInterval
    difference: MeanInterval | None  # None at the model's own integrator and step
    episodes: int  # number of pairs
    lost: int  # number of episodes whose run was lost at this step, and do not count
    length: float  # [s] mean duration of the episodes, which an environment may end
    engine: str = "mujoco"


@dataclass(frozen=True)
class EpisodeReturns:
    """The returns of episodes at several steps, the model's own first."""

    rows: tuple[StepReturn, ...]
    # Return in the limit of small steps, less the return at the model's own step; None if there is
    # no limit, and `no_limit` says why
    limit: MeanInterval | None
    no_limit: str
    asked: int  # number of episodes that were asked for
    # Returns of each episode by row, shape (episodes, rows); NaN where a run was lost
    values: Array

    @property
    def own(self) -> StepReturn:
        """The returns at the model's own integrator and step."""
        return self.rows[0]

    @property
    def difference(self) -> MeanInterval | None:
        """The return in the limit, or else at the finest step of the model's own integrator, less
        the return at the model's own step; None if too few episodes reach their end."""
        if self.limit is not None:
            return self.limit
        same = [row for row in self.rows if row.integrator == self.own.integrator]
        return same[-1].difference

    @property
    def scale(self) -> float:
        """The size of the return that differences are relative to: that of small steps."""
        change = 0.0 if self.difference is None else self.difference.mean
        return abs(self.own.mean.mean + change)

    def relative(self, value: float) -> float:
        """Returns a difference of returns relative to the return of small steps."""
        return value / self.scale if self.scale else math.inf

    def within(self, fraction: float) -> bool:
        """Whether the step changes the return by no more than a fraction of it, at the far end of
        the interval."""
        change = self.difference
        if change is None:
            return False
        return max(abs(change.low), abs(change.high)) <= fraction * self.scale


def interval_of(values: Array) -> MeanInterval:
    """Returns the mean of values, shape (n,) with n of 2 or more, with its intervals."""
    from scipy import stats

    mean = float(values.mean())
    error = float(values.std(ddof=1)) / math.sqrt(len(values))
    half = float(stats.t.ppf((1.0 + CONFIDENCE) / 2, len(values) - 1)) * error
    low, high = mean, mean
    if error > 0.0:
        resampled = stats.bootstrap(
            (values,),
            np.mean,
            confidence_level=CONFIDENCE,
            n_resamples=RESAMPLES,
            method="percentile",
            rng=np.random.default_rng(0),
        ).confidence_interval
        low, high = float(resampled.low), float(resampled.high)
    return MeanInterval(mean, mean - half, mean + half, low, high)


def limit_of(returns: Sequence[Array], order: int) -> tuple[MeanInterval | None, str]:
    """Returns the difference of the limit of small steps from the largest of three steps, each half
    of the one before, with `returns` of shape (episodes,) each; or None and the reason. The second
    change must be 2^order times smaller than the first, within OFF_ORDER and its interval. If it is
    resolved that it is not exactly so, a term of the next order is in the error. Less than the
    difference is then left in the limit, and the interval is wider by as much."""
    coarse, middle, fine = returns
    first, second = middle - coarse, fine - middle
    whole = interval_of(first)
    if not whole.resolved:
        return None, "halving the step changes the mean by less than the episodes resolve"
    expected = first / 2.0**order
    excess = interval_of(second - expected)
    if abs(excess.mean) > excess.half + OFF_ORDER * abs(whole.mean) / 2.0**order:
        return None, f"its changes do not fall as the step to the power {order}"
    limit = interval_of(fine + second / (2.0**order - 1.0) - coarse)
    left = abs(excess.mean) if excess.resolved else 0.0
    return (
        MeanInterval(
            limit.mean,
            limit.low - left,
            limit.high + left,
            limit.bootstrap_low - left,
            limit.bootstrap_high + left,
        ),
        "",
    )


@dataclass(frozen=True)
class Setting:
    """An integrator, its step [s], and the number of these steps in a control period."""

    integrator: str
    step: float
    parts: int


def returns_of(
    settings: Sequence[Setting], outcomes: Array, asked: int
) -> EpisodeReturns | None:
    """Returns the mean returns at settings, the model's own first and its halved steps next, from
    the return and the duration [s] of each episode, shape (episodes, settings, 2), with NaN for
    runs that were lost; None if fewer than two episodes count at the model's own step. `asked`
    is the number of episodes that were asked for."""
    values = outcomes[:, :, 0]
    good = np.isfinite(values) & np.isfinite(values[:, :1])
    enough = [k for k in range(len(settings)) if good[:, k].sum() > 1]
    if 0 not in enough:
        return None
    rows = []
    for k in enough:
        pairs = outcomes[good[:, k]]
        change = pairs[:, k, 0] - pairs[:, 0, 0]
        rows.append(
            StepReturn(
                integrator=settings[k].integrator,
                step=settings[k].step,
                mean=interval_of(pairs[:, k, 0]),
                difference=interval_of(change) if k else None,
                episodes=len(pairs),
                lost=int(np.isnan(values[:, k]).sum()),
                length=float(pairs[:, k, 1].mean()),
            )
        )
    three = values[:, : len(HALVED)]
    three = three[np.isfinite(three).all(axis=1)]
    limit, why = None, "too few episodes count at the halved steps"
    if len(three) > 1:
        limit, why = limit_of(list(three.T), ORDERS.get(settings[0].integrator, 1))
    return EpisodeReturns(tuple(rows), limit, why, asked, values[:, enough])
