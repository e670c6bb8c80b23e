"""A scene built for one pymunk method and step, and its runs."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Protocol, cast

import numpy as np
import pymunk

from plumbob.engines import sampling
from plumbob.engines.adapters.divergence import within
from plumbob.engines.method import Method, Stepping
from plumbob.engines.registry import find_builder
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Case, System


@dataclass(frozen=True)
class Translation:
    """A scene as a space at its start, what to do before each step, and what to read off it."""

    space: pymunk.Space
    read: Callable[[], Mapping[str, float]]  # the observables, and any channels, of this moment
    act: Callable[[float], None] | None = None
    """Called with the time [s] before each step: forces last for one step."""
    channels: frozenset[str] = frozenset()  # names that `read` gives beside the observables
    limits: Mapping[str, float] = field(default_factory=dict)
    """Magnitudes of observables that only a diverged run exceeds."""
    following: Callable[[], Mapping[str, float]] | None = None
    """Observables of the step that begins at a sample: read when it is done."""
    before_sample: Callable[[float], None] | None = None
    """Called with the time [s] before the step that ends at a sample."""


class Builder(Protocol):
    """The interface of a module `adapters/pymunk/<family>.py`, one for a family of systems."""

    def build(self, problem: Any, method: Method, step: float) -> Translation:
        """Translate `problem` for `method` at `step` [s]; raises Unsupported."""
        ...

    def model_error(
        self, problem: Any, duration: float, method: Method, step: float
    ) -> Mapping[str, Mapping[str, float]]:
        """Bounds on what the model adds to each observable over `duration` [s], by reason."""
        ...


def builder(system: System) -> Builder:
    """The builder of `system`; raises Unsupported when there is none."""
    return cast(Builder, find_builder("pymunk", system))


@dataclass
class PymunkSimulation:
    """A scene that is rebuilt for every run: a space keeps no start to go back to."""

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
            except (OverflowError, ValueError):  # Python's squares and sines of infinity
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

    def stepped(self, fraction: float) -> Stepping:
        """The steps of the first `fraction` of the duration alone."""
        built, steps = self.build(), sampling.first_steps(self.steps, fraction)
        try:
            return Stepping(steps, _timed(built, 0, steps, self.step, time.thread_time))
        except (OverflowError, ValueError):
            return Stepping(0, 0.0)


def _advance(
    built: Translation, first: int, last: int, step: float, sample: dict[str, float]
) -> float:
    """Take the steps `first` to `last` - 1 of length `step` [s], add to the `sample` at `first`
    what the step that follows it gives, and return the wall time of the stepping [s]."""
    if built.before_sample is not None:
        seconds = _timed(built, first, last - 1, step)
        built.before_sample((last - 1) * step)
        return seconds + _timed(built, last - 1, last, step)
    if built.following is None:
        return _timed(built, first, last, step)
    seconds = _timed(built, first, first + 1, step)
    sample.update(built.following())
    return seconds + _timed(built, first + 1, last, step)


def _timed(
    built: Translation,
    first: int,
    last: int,
    step: float,
    clock: Callable[[], float] = time.perf_counter,
) -> float:
    begin, move, act = clock(), built.space.step, built.act
    if act is None:
        for _ in range(first, last):
            move(step)
    else:
        for n in range(first, last):
            act(n * step)
            move(step)
    return clock() - begin


def prepared(case: Case, method: Method, step: float) -> PymunkSimulation:
    """Build `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    steps = sampling.step_count(case.scene.duration, step)
    chosen, problem = builder(case.system), case.problem
    begin = time.perf_counter()
    chosen.build(problem, method, step)
    seconds = time.perf_counter() - begin
    return PymunkSimulation(lambda: chosen.build(problem, method, step), steps, step, seconds)
