"""Ensemble means at two steps, where no single motion can be predicted."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.reference import Array
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
        apart = [
            abs(a - b) / error if error > 0.0 else 0.0
            for a, b, error in zip(self.own, self.finer, self.standard_errors, strict=True)
        ]
        worst = int(np.argmax(apart))
        return MEANS[worst], apart[worst]


def likely(
    model: OwnModel,
    script: Script,
    parts: int,
    budget: float,
    clock: Callable[[], float] = time.process_time,
    executor: Executor | None = None,
) -> Likely | None:
    """Means at the end over `STARTS` starts near that of `script`, at `parts` steps in a period and
    at more; None where that would take longer than `budget` [s], or runs diverge. Starts run beside
    each other in an `executor`, if given."""
    starts = model.starts(STARTS, SIZE)
    begin, pairs = clock(), []
    tasks = [executor.submit(pair, model, script, parts, s) for s in starts] if executor else []
    for done, start in enumerate(starts, start=1):
        pairs.append(tasks[done - 1].result() if tasks else pair(model, script, parts, start))
        if (clock() - begin) / done * STARTS > budget:
            [task.cancel() for task in tasks]
            return None
    values = np.array(pairs)  # shape (starts, 2, means)
    if not np.isfinite(values).all():
        return None
    means, finer = values.mean(axis=0)
    # Near the start both follow each other, far beyond neither does: the differences of pairs say
    # how far means may be apart by chance in both cases.
    errors = (values[:, 0] - values[:, 1]).std(axis=0, ddof=1) / math.sqrt(STARTS)
    return Likely(STARTS, tuple(means.tolist()), tuple(finer.tolist()), tuple(errors.tolist()))


def pair(model: OwnModel, script: Script, parts: int, start: Array) -> list[Array]:
    """Means at the end, from one start, at `parts` steps in a period and at more."""
    moved = replace(script, start=start)
    return [
        _means(model, start, model.stepped(moved, model.integrator, n).states[-1])
        for n in (parts, FINER * parts)
    ]


def _means(model: OwnModel, start: Array, end: Array) -> Array:
    first, last = model.positions(np.stack([start, end]))
    moved = np.linalg.norm(last - first, axis=1).mean()
    return np.array([*last.mean(axis=0), moved])
