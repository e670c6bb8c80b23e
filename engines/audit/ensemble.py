"""Ensemble means at two steps, where no single motion can be predicted."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.own_motion import OwnModel, Script

STARTS = 24
SIZE = 1e-3  # [m or rad] standard deviation of the starts in each coordinate
FINER = 4  # times as many steps, to compare with
STANDS_OUT = 3.0  # standard errors: of four means, one in a hundred cases has that by chance
MEANS = ("mean x", "mean y", "mean height", "mean distance moved")  # of all bodies at the end [m]


@dataclass(frozen=True)
class Likely:
    """Means over many starts at the own step and at a finer one."""

    starts: int
    own: tuple[float, ...]  # [m], as in `MEANS`
    finer: tuple[float, ...]
    standard_errors: tuple[float, ...]  # [m] of their differences

    @property
    def most(self) -> tuple[str, float]:
        """The mean that differs most, and by how many standard errors."""
        errors, apart = np.array(self.standard_errors), np.subtract(self.own, self.finer)
        ratios = np.abs(np.divide(apart, errors, out=np.zeros_like(errors), where=errors > 0.0))
        worst = int(np.argmax(ratios))
        return MEANS[worst], float(ratios[worst])


def likely(model: OwnModel, script: Script, parts: int, allowance: Allowance) -> Likely | None:
    """Means at the end over `STARTS` starts near that of `script`, at `parts` steps in a period and
    at more; None where that would take longer than is allowed, or runs diverge."""
    starts, pairs = model.starts(STARTS, SIZE), []
    tasks = [allowance.start(pair, model, script, parts, start) for start in starts]
    for task in tasks:
        pairs.append(task())
        if allowance.spent / len(pairs) * STARTS > allowance.seconds:
            return None
    values = np.array(pairs)  # shape (starts, 2, means)
    if not np.isfinite(values).all():
        return None
    # Near the start both follow each other, far beyond neither does: the differences of pairs say
    # how far means may be apart by chance in both cases.
    errors = (values[:, 0] - values[:, 1]).std(axis=0, ddof=1) / math.sqrt(STARTS)
    rows = (tuple(row.tolist()) for row in (*values.mean(axis=0), errors))
    return Likely(STARTS, *rows)


def pair(model: OwnModel, script: Script, parts: int, start: Array) -> list[Array]:
    """Means at the end, from one start, at `parts` steps in a period and at more."""
    begun = replace(script, start=start)
    runs = (model.stepped(begun, model.integrator, n).states for n in (parts, FINER * parts))
    means = []
    for states in runs:
        first, last = model.positions(states[[0, -1]])
        means.append(np.array([*last.mean(axis=0), np.linalg.norm(last - first, axis=1).mean()]))
    return means
