"""Means over episodes: how much of a return is the time step's? Each episode has a start of its
own, from which runs at several steps begin: their returns are compared by pairs.

Beyond the horizon of a chaotic motion two runs part, and means over many starts still converge with
the step.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError, positive
from plumbob.analytic.reference import Array
from plumbob.engines.own_motion import OwnModel, Script, Stepped, policy_name
from plumbob.engines.tangent_space import space_of_layout
from plumbob.models.border import must_be
from plumbob.models.entry_points import on_stderr

CONFIDENCE = 0.95  # confidence of all intervals
HALVED = (1, 2, 4)  # the model's own step over these is run
# Largest relative difference of a change from that of its order: a term of the next order is then
# a small part of the error
OFF_ORDER = 0.5
RESAMPLES = 2000  # resamples of a bootstrap
# [m, rad, and these per second] default largest change of a coordinate of the start
START_SPREAD = 0.01
MOST_EPISODES = 100_000
# Order of the errors of means at small steps, by integrator; others are of first order
ORDERS = MappingProxyType({"rk4": 4})
Metric = Callable[..., Any]
"""Times [s], shape (n + 1,), positions, velocities, and controls, shape (n, actuators), of an
episode -> its return, a number."""


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
    difference: MeanInterval | None  # None: the own integrator and step
    episodes: int  # number of pairs
    lost: int  # number of episodes that ended early at this step, and do not count
    engine: str = "mujoco"


@dataclass(frozen=True)
class EpisodeReturns:
    """The returns of episodes at several steps, the model's own first."""

    rows: tuple[StepReturn, ...]
    # The difference of the limit of small steps from the own step; None where `no_limit` says why
    limit: MeanInterval | None
    no_limit: str
    asked: int  # number of episodes that were asked for

    @property
    def own(self) -> StepReturn:
        """The returns at the model's own integrator and step."""
        return self.rows[0]

    @property
    def difference(self) -> MeanInterval | None:
        """The difference of the limit, or else of the finest step of the own integrator, from the
        own step; None if too few episodes reach their end."""
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
class EpisodePlan:
    """So many episodes (`count`), the `metric` that gives the return of each, and the `spread` of
    their starts: each coordinate and velocity is moved by up to this, in m, rad, and per second.
    Raises ParameterError."""

    count: int
    metric: Metric
    spread: float = START_SPREAD

    def __post_init__(self) -> None:
        if isinstance(self.count, bool) or not 2 <= self.count <= MOST_EPISODES:
            raise ParameterError("episodes", self.count, f"a number from 2 to {MOST_EPISODES}")
        positive("spread", self.spread)


@dataclass(frozen=True)
class Episodes:
    """The episodes of a model: runs of a script from starts that a plan spreads."""

    model: OwnModel
    script: Script
    plan: EpisodePlan

    def start(self, number: int) -> Array:
        """Returns the start of an episode: each coordinate and velocity of the script's start is
        moved by up to the spread, uniformly, by the random numbers of that episode."""
        space = space_of_layout(self.model.layout)
        size = 2 * space.velocities
        draw = np.random.default_rng(number)
        shift = np.zeros(space.size(self.model.state))
        shift[:size] = draw.uniform(-self.plan.spread, self.plan.spread, size)
        return self.model.shifted(self.script.start, shift)

    def returned(self, number: int, integrator: str, parts: int) -> float:
        """Returns the return of an episode at `parts` steps in a control period; NaN if its run
        ends early. Raises ParameterError."""
        script = replace(self.script, start=self.start(number))
        run = self.model.stepped(script, integrator, parts)
        return math.nan if run.why else self._measured(run, script)

    def _measured(self, run: Stepped, script: Script) -> float:
        """Returns the metric of a run. Raises ParameterError unless it is a finite number."""
        velocities = self.model.layout.velocity
        states = run.states
        wanted = "a function of times, qpos, qvel and controls that returns a finite number"
        arguments = (
            script.times,
            states[:, : velocities.start].copy(),
            states[:, velocities].copy(),
            run.controls.copy(),
        )
        name = policy_name(self.plan.metric)
        with must_be(wanted, "metric", name), on_stderr():
            value = float(self.plan.metric(*arguments))
        if not math.isfinite(value):
            raise ParameterError("metric", name, f"{wanted}, not {value}")
        return value

    def returns(self, seconds: float, progress: Callable[[str], None]) -> EpisodeReturns:
        """Returns the returns of the episodes at the own step, at halves of it, and with other
        integrators at the own step. Fewer are run if they take more than `seconds` of processor
        time, but at least two. Raises ParameterError."""
        count = self.plan.count
        own = self.script.parts(self.model.step)
        settings = [(self.model.integrator, own * finer) for finer in HALVED]
        settings += [(other, own) for other in self.model.integrators[1:]]
        values = self._table(settings, seconds, progress)
        rows = (
            self._row(setting, values[:, [0, column]])
            for column, setting in enumerate(settings)
        )
        found = tuple(row for row in rows if row is not None)
        if not found or found[0].difference is not None:
            raise ParameterError(
                "episodes", count, "so many that two reach their end at the own step"
            )
        three = values[:, : len(HALVED)]
        three = three[np.isfinite(three).all(axis=1)]
        order = ORDERS.get(self.model.integrator, 1)
        limit, why = None, "too few episodes reach their end"
        if len(three) > 1:
            limit, why = limit_of(list(three.T), order)
        return EpisodeReturns(found, limit, why, count)

    def _table(
        self,
        settings: Sequence[tuple[str, int]],
        seconds: float,
        progress: Callable[[str], None],
    ) -> Array:
        """Returns the returns of the episodes that the time allows, shape (episodes, settings),
        with NaN for runs that ended early."""
        ends = time.process_time() + seconds
        table: list[list[float]] = []
        for number in range(self.plan.count):
            if number >= 2 and time.process_time() > ends:
                break
            progress(f"episode {number + 1} of {self.plan.count}")
            table.append([self.returned(number, *setting) for setting in settings])
        return np.array(table)

    def _row(self, setting: tuple[str, int], pairs: Array) -> StepReturn | None:
        """Returns the returns of an integrator and steps in a period, from pairs of returns at the
        own step and at this one, shape (episodes, 2); None if fewer than two pairs count."""
        integrator, parts = setting
        good = pairs[np.isfinite(pairs).all(axis=1)]
        if len(good) < 2:
            return None
        own = setting == (self.model.integrator, self.script.parts(self.model.step))
        return StepReturn(
            integrator=integrator,
            step=self.script.period / parts,
            mean=interval_of(good[:, 1]),
            difference=None if own else interval_of(good[:, 1] - good[:, 0]),
            episodes=len(good),
            lost=int(np.isnan(pairs[:, 1]).sum()),
        )
