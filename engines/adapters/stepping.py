"""Simulations of scenes: in an engine that is advanced step by step, and by a solver that chooses
its steps. A scene is rebuilt for every run, sampled and timed."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError, positive
from plumbob.analytic.reference import Array, Signals
from plumbob.engines import sampling
from plumbob.engines.adapters.divergence import within
from plumbob.engines.controlled_steps import TakeSteps
from plumbob.engines.method import Stepping
from plumbob.engines.trajectory import ByName, Trajectory
from plumbob.models.scene import Case

OVERFLOW = (ArithmeticError, ValueError)  # Python's exceptions for infinite numbers
Observed = tuple[Signals, Signals]  # observables and channels
# Arrays may overflow while a run diverges: the run is cut when its samples are read.
DIVERGING = np.errstate(over="ignore", invalid="ignore")


def by_name(rows: Sequence[ByName]) -> Observed:
    """The observables of samples, shape (len(rows),) each, and no channels."""
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}, {}


@dataclass(frozen=True)
class Built:
    """A scene at its start in an engine."""

    advance: TakeSteps  # called once from sample to sample
    read: Callable[[], Any]  # returns the present state, or its observables
    limits: ByName = field(default_factory=dict)
    """Magnitudes of observables that only a diverged run exceeds."""
    gather: Callable[[Sequence[Any]], Observed] = by_name
    """Everything that `read` returned -> observables and channels, shape (samples,) each."""


def thread_time() -> float:
    """The processor time that this thread has used [s]."""
    return time.thread_time()


@dataclass
class SteppedSimulation:
    """A scene that is rebuilt for every run and advanced in steps of one length."""

    build: Callable[[], Built]
    steps: int
    step: float  # [s]
    compile_seconds: float
    broken: tuple[type[Exception], ...] = OVERFLOW
    """The engine's exceptions if its numbers are no longer finite."""
    samples: int = sampling.MAX_SAMPLES  # largest number of samples
    clock: Callable[[], float] = thread_time  # [s] clock for the cost of steps

    @DIVERGING
    def run(self) -> Trajectory:
        """Runs from the start to the end, or until the run diverges."""
        built = self.build()
        marks = [int(mark) for mark in sampling.sampled(self.steps, self.samples)]
        rows = [built.read()]
        seconds = 0.0
        diverged = None
        failure = ""
        for first, last in pairwise(marks):
            try:
                begin = time.perf_counter()
                built.advance(first, last)
                seconds += time.perf_counter() - begin
                rows.append(built.read())
            except self.broken as error:
                diverged = last * self.step
                failure = "" if isinstance(error, OVERFLOW) else " ".join(str(error).split())
                break
        observables, channels = built.gather(rows)
        return within(
            Trajectory(
                times=np.array(marks[: len(rows)]) * self.step,
                observables=observables,
                channels=channels,
                steps=marks[len(rows) - 1],
                seconds=seconds,
                diverged_at=diverged,
                warnings=(failure,) if failure else (),
            ),
            built.limits,
        )

    @DIVERGING
    def stepped(self, fraction: float) -> Stepping:
        """Takes the steps of the first `fraction` of the duration, and reads no state."""
        built = self.build()
        steps = sampling.first_step_count(self.steps, fraction)
        begin = self.clock()
        try:
            built.advance(0, steps)
        except self.broken:
            return Stepping(0, 0.0)
        return Stepping(steps, self.clock() - begin)


@dataclass(frozen=True)
class Followed:
    """The samples of a solver that chooses its steps."""

    times: Array  # [s] times of the samples, shape (n,)
    states: Any  # states at these times, for `FollowedSimulation.observe`
    evaluations: int  # number of evaluations of the right-hand side
    ended: bool = True  # whether the solver reached the end
    why: tuple[str, ...] = ()  # messages of the solver


@dataclass
class FollowedSimulation:
    """A scene under a solver that chooses its steps."""

    follow: Callable[[float, int], Followed]
    """Duration [s], approximate number of samples (1: only the solver is timed) -> the samples."""
    observe: Callable[[Any], Signals]
    """States of all samples -> observables, shape (n,) each."""
    duration: float  # [s]
    compile_seconds: float = 0.0
    limits: ByName = field(default_factory=dict)
    samples: int = sampling.MAX_SAMPLES

    def run(self) -> Trajectory:
        """Runs from the start to the end, or until the run diverges or the solver gives up."""
        begin = time.perf_counter()
        done = self.follow(self.duration, self.samples)
        seconds = time.perf_counter() - begin
        trajectory = Trajectory(
            times=done.times,
            observables=self.observe(done.states),
            steps=done.evaluations,
            seconds=seconds,
            diverged_at=None if done.ended else float(done.times[-1]),
            warnings=done.why,
        )
        return within(trajectory, self.limits)

    def stepped(self, fraction: float) -> Stepping:
        """Integrates the first `fraction` of the duration, and keeps no samples."""
        begin = time.thread_time()
        done = self.follow(fraction * self.duration, 1)
        return Stepping(done.evaluations, time.thread_time() - begin)


def stepped(
    case: Case,
    step: float,
    build: Callable[[], Built],
    broken: tuple[type[Exception], ...] = OVERFLOW,
) -> SteppedSimulation:
    """The simulation of `case` at `step` [s]. The scene is built once to see whether it can be
    built, and how long that takes. Raises the exceptions of `build`, and ParameterError."""
    steps = sampling.step_count(case.scene.duration, step)
    begin = time.perf_counter()
    build()
    seconds = time.perf_counter() - begin
    return SteppedSimulation(build, steps, step, seconds, broken, case.samples)


def relative_tolerance(tolerance: float, smallest: float) -> float:
    """Returns the relative `tolerance`, which a method is given as its step; raises ParameterError
    unless it lies between `smallest` and 1."""
    if not smallest <= positive("step", tolerance) < 1.0:
        wanted = f"a relative tolerance from {smallest:.1e} to below 1"
        raise ParameterError("step", tolerance, wanted)
    return tolerance
