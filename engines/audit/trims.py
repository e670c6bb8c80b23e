"""Ablation of a model on one motion: each feature is removed alone, then all that help together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple

import numpy as np

from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.costs import Ratio, costs_in_turns, ratio, timed_periods
from plumbob.engines.audit.reference import largest_displacement
from plumbob.engines.own_motion import Change, OwnModel, Script, Stepped

# Largest change of the motion that is accepted, as a fraction of the step's own error
TENTH = 0.1
# Largest cost, as a fraction of the complete model's, at which features are removed. A feature that
# saves too little to measure is removed with the others, so that the choice does not depend on the
# scatter of costs.
SAVES = 0.98


@dataclass(frozen=True)
class Trim:
    """The effects of an ablation on the motion and on the cost of the model's own steps."""

    changes: tuple[Change, ...]
    same_bits: bool
    moved: float  # [m] largest displacement of a corner, as long as errors are known
    cost: Ratio  # multiple of the complete model's cost

    @property
    def name(self) -> str:
        """The names of the removed features."""
        return ", ".join(change.name for change in self.changes)

    def accepted(self, error: float) -> bool:
        """Whether the motion is bitwise the same, or changes by less than a tenth of the step's
        `error` [m]."""
        return self.same_bits or self.moved <= TENTH * error


class TrimmedFile(NamedTuple):
    """A model file that was written without the features that can be left out."""

    name: str
    read_back: Trim  # effects of the file's model, after it was read back


@dataclass(frozen=True)
class Trims:
    """All ablations that were tried, and the accepted ones together if they save something."""

    each: tuple[Trim, ...]
    together: Trim | None


def trims(
    model: OwnModel,
    script: Script,
    parts: int,
    index: int,
    error: float,
    allowance: Allowance,
) -> Trims:
    """Returns the ablations of the features that `model` offers to remove, under `script` with
    `parts` steps in a period. The `error` [m] is known up to the period `index`."""
    offered = [((change,), model.changed((change,))) for change in model.changes(script)]
    single = effects_of_changes(model, script, parts, index, offered, allowance)
    saving = [trim for trim in single if trim.accepted(error) and trim.cost.low <= 1.0]
    saving = [trim for trim in saving if trim.same_bits] or saving
    if not saving:
        return Trims(single, None)
    together = tuple(chain.from_iterable(trim.changes for trim in saving))
    (combined,) = effects_of_changes(
        model, script, parts, index, [(together, model.changed(together))]
    )
    return Trims(
        single, combined if combined.accepted(error) and combined.cost.high < SAVES else None
    )


def effects_of_changes(
    model: OwnModel,
    script: Script,
    parts: int,
    index: int,
    offered: Sequence[tuple[tuple[Change, ...], OwnModel]],
    allowance: Allowance | None = None,
) -> tuple[Trim, ...]:
    """Returns the effects of changes of `model`. `offered` has each change with the changed model;
    the first that the time allows are tried."""
    models = [model, *(other for _, other in offered)]
    runs: list[Stepped] = []
    for variant in models:
        if allowance is not None and allowance.left < 0.0:
            break
        runs.append(variant.stepped(script, variant.integrator, parts))
    if len(runs) < 2:
        return ()
    states = runs[0].states[np.isfinite(runs[0].states).all(axis=1)]
    timed = [
        timed_periods(variant, script, states, variant.integrator, parts, run.seconds)
        for variant, run in zip(models, runs, strict=False)
    ]
    full_cost, *costs = costs_in_turns(timed)
    return tuple(
        Trim(
            changes,
            np.array_equal(runs[0].states, run.states, equal_nan=True),
            largest_displacement(model, runs[0].states[: index + 1], run.states[: index + 1]),
            ratio(cost, full_cost),
        )
        for (changes, _), run, cost in zip(offered, runs[1:], costs, strict=False)
    )
