"""Costs of a model's own steps, warm, in turns, beside reference steps: as a study measures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.own_motion import OwnModel, Script
from plumbob.engines.study.cost import Cost, TimedSteps, in_turns
from plumbob.engines.trajectory import Timed

PIECE = 5e-3  # [s] of processor time, about, that is timed at once
PLACES = 8  # of a motion, at least, where it has as many periods
TURNS = 9  # at most; on a machine that nobody else uses three agree
# Of the cheapest cost: what costs no more is as cheap. Steps are halved, and RK4 has four stages,
# so that costs differ by little or by nearly two.
ALIKE = 1.25


@dataclass(frozen=True)
class Ratio:
    """A cost over another: the medians', and what the quartiles of both leave open, which are
    independent of each other."""

    value: float
    low: float
    high: float

    @property
    def saves(self) -> bool:
        """Whether it is clearly less than 1."""
        return self.high * ALIKE < 1.0


def ratio(cost: Cost, other: Cost, steps: float = 1.0) -> Ratio:
    """`steps` steps at the cost of one over one at the cost of the other."""
    value = steps * cost.ns_per_step / other.ns_per_step
    below = math.hypot(1.0 - cost.low / cost.ns_per_step, other.high / other.ns_per_step - 1.0)
    above = math.hypot(cost.high / cost.ns_per_step - 1.0, 1.0 - other.low / other.ns_per_step)
    return Ratio(value, value / (1.0 + below), value * (1.0 + above))


def timed_periods(
    model: OwnModel, script: Script, states: Array, integrator: str, parts: int, seconds: float
) -> Timed:
    """About `PIECE` [s] of the motion whose `states`, shape (n, ...), are known, at `parts` steps
    in a control period: repeated where it is shorter, else beginnings of periods all over it;
    `seconds` is what the whole motion takes."""
    periods = min(len(states), len(script.controls))
    wanted = PIECE / max(seconds, 1e-9) * len(script.controls)
    count = max(min(PLACES, periods), math.ceil(wanted))
    places = np.linspace(0, periods - 1, min(periods, count)).astype(int)
    chosen = np.resize(places, count)
    steps = math.ceil(parts * min(1.0, wanted / count))
    begun = states[chosen]
    if steps == parts:
        begun[1:][np.diff(chosen) == 1] = np.nan  # it goes on
    some = Script(script.start, script.period, script.controls[chosen])
    return model.timed(some, begun, integrator, parts, steps)


def costs_in_turns(timed: Sequence[Timed]) -> tuple[Cost, ...]:
    """The cost of a step of each."""
    pieces = {k: TimedSteps(run, 1.0) for k, run in enumerate(timed)}
    return tuple(in_turns(pieces, TURNS)[0].values())
