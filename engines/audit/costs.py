"""Costs of a model's own steps, warm and measured in turns with reference steps, as in a study."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.own_motion import OwnModel, Script
from plumbob.engines.study.cost import Cost, TimedSteps, in_turns
from plumbob.engines.trajectory import TimedSimulation

PIECE = 5e-3  # [s] approximate processor time of one timed piece
PLACES = 8  # least number of places of a motion that are timed, if it has as many periods
TURNS = 9  # most turns; on an idle machine three agree
# Ratio of costs up to which they count as alike. Steps are halved, and RK4 has four stages: costs
# differ by little or by nearly two.
ALIKE = 1.25


@dataclass(frozen=True)
class Ratio:
    """A ratio of two costs: of their medians, with bounds from the quartiles of both, which are
    taken as independent."""

    value: float
    low: float
    high: float

    @property
    def saves(self) -> bool:
        """Whether the ratio is clearly less than 1."""
        return self.high * ALIKE < 1.0


def ratio(cost: Cost, other: Cost, steps: float = 1.0) -> Ratio:
    """Returns the ratio of the cost of `steps` steps at `cost` to the cost of one step at
    `other`."""
    value = steps * cost.ns_per_step / other.ns_per_step
    below = math.hypot(1.0 - cost.low / cost.ns_per_step, other.high / other.ns_per_step - 1.0)
    above = math.hypot(cost.high / cost.ns_per_step - 1.0, 1.0 - other.low / other.ns_per_step)
    return Ratio(value, value / (1.0 + below), value * (1.0 + above))


def timed_periods(
    model: OwnModel, script: Script, states: Array, integrator: str, parts: int, seconds: float
) -> TimedSimulation:
    """Returns steps to be timed: about `PIECE` [s] of the motion with known `states`, shape (n,
    ...), at `parts` steps in a control period. A shorter motion is repeated; in a longer motion the
    steps are the beginnings of periods spread over it. `seconds` is the time of the whole
    motion."""
    periods = min(len(states), len(script.controls))
    wanted = PIECE / max(seconds, 1e-9) * len(script.controls)
    count = max(min(PLACES, periods), math.ceil(wanted))
    places = np.linspace(0, periods - 1, min(periods, count)).astype(int)
    chosen = np.resize(places, count)
    steps = math.ceil(parts * min(1.0, wanted / count))
    starts = states[chosen]
    if steps == parts:
        starts[1:][np.diff(chosen) == 1] = np.nan  # the period continues the one before
    timed_script = Script(script.start, script.period, script.controls[chosen])
    return model.timed(timed_script, starts, integrator, parts, steps)


def costs_in_turns(timed: Sequence[TimedSimulation]) -> tuple[Cost, ...]:
    """Returns the cost of a step of each of the timed runs."""
    pieces = {k: TimedSteps(run, 1.0) for k, run in enumerate(timed)}
    return tuple(in_turns(pieces, TURNS)[0].values())
