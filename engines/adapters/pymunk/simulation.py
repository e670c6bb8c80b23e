"""A scene built for one pymunk method and step, and its runs."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from plumbob.engines.adapters import sampling
from plumbob.engines.adapters.divergence import within
from plumbob.engines.adapters.pymunk.translation import Translation, builder
from plumbob.engines.method import Method
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Case


@dataclass
class PymunkSimulation:
    """A scene that can be built anew for every run: a space keeps no start to go back to."""

    build: Callable[[], Translation]
    steps: int
    step: float  # [s]
    compile_seconds: float

    def run(self) -> Trajectory:
        """Run from the start to the end, or until the run diverges."""
        built = self.build()
        h = self.step
        marks = [int(mark) for mark in sampling.sampled(self.steps)]
        rows, seconds, diverged = [dict(built.read())], 0.0, None
        for first, last in pairwise(marks):
            try:
                seconds += _advance(built, first, last, h, rows[-1])
                rows.append(dict(built.read()))
            except (OverflowError, ValueError):  # what Python says to squares and sines of infinity
                diverged = last * h
                break
        if built.following is not None:
            _advance(built, self.steps, self.steps + 1, h, rows[-1])
        values = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        trajectory = Trajectory(
            times=np.array(marks[: len(rows)]) * h,
            observables={n: v for n, v in values.items() if n not in built.channels},
            channels={n: v for n, v in values.items() if n in built.channels},
            steps=marks[len(rows) - 1],
            seconds=seconds,
            diverged_at=diverged,
        )
        return within(trajectory, built.limits)


def _advance(
    built: Translation, first: int, last: int, step: float, sample: dict[str, float]
) -> float:
    """Take the steps `first` to `last` - 1 of length `step` [s], add to the `sample` at `first`
    what the step that follows it gives, and return the wall time of the stepping [s]."""
    if built.following is None:
        return _timed(built, first, last, step)
    seconds = _timed(built, first, first + 1, step)
    sample.update(built.following())
    return seconds + _timed(built, first + 1, last, step)


def _timed(built: Translation, first: int, last: int, step: float) -> float:
    begin, move, act = time.perf_counter(), built.space.step, built.act
    if act is None:
        for _ in range(first, last):
            move(step)
    else:
        for n in range(first, last):
            act(n * step)
            move(step)
    return time.perf_counter() - begin


def prepared(case: Case, method: Method, step: float) -> PymunkSimulation:
    """Build `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    steps = sampling.step_count(case.scene.duration, step)
    chosen, problem = builder(case.system), case.problem
    begin = time.perf_counter()
    chosen.build(problem, method, step)
    seconds = time.perf_counter() - begin
    return PymunkSimulation(lambda: chosen.build(problem, method, step), steps, step, seconds)
