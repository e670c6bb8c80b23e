"""Step limits by trial: steps of many sizes at once, with a nudge and the kind of motion.

A step size is too large if a nudge of the start grows much more than in the exact motion, or if the
kind of motion changes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plumbob.analytic.errors.smooth_motion.scheme_steps import SchemeStep, StateParts
from plumbob.analytic.errors.stability.flow_growth import GROWTH_TO_MOTION_SIZE
from plumbob.analytic.errors.stability.largest_step import (
    LEAST_PERIODS,
    StableMarks,
    run_length,
)
from plumbob.analytic.numerics.smooth.smooth_system import IMAGINARY_STEP
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.stability import (
    LARGEST_STEP_AWAY,
    LOST_GROWTH,
    TRIAL_STEP_RATIO,
    TRIAL_STRIDE,
    FailureKind,
    StepLimit,
    exponent,
)

NUDGE_SAMPLES = 256  # samples of nudge and kind along a run
GOLDEN_RATIO = 0.5 * (math.sqrt(5.0) - 1.0)
FIRST_PASS_SIZES = 48  # number of step sizes in the first pass
FIRST_PASS_RUN_STEPS = 1000  # steps of a run in the first pass
# The second pass tests steps down to a factor TRIAL_STEP_RATIO**140 = 4 below the first failure.
STEPS_BELOW_FAILURE = 140
# [fastest periods] smallest and largest step of the first pass
FIRST_PASS_STEPS = (0.02 / math.tau, LARGEST_STEP_AWAY)
StepCounts = npt.NDArray[np.int64]


@dataclass(frozen=True)
class SteppedMotion:
    """A scheme's steps on one exact motion, and the properties of the exact motion."""

    begin: Callable[[Array], tuple[SchemeStep, StateParts]]
    """Function from step sizes [s], shape (n,), to the scheme's step and its initial state. A state
    has parts of shape (n,)."""
    names: Sequence[str]  # observables: names of a state's first parts
    scales: Sequence[float]  # units of a state's first parts, in which they are nudged
    fastest: float  # [s] shortest period of the exact motion
    growth: Callable[[Array], Array]  # growth in the exact motion, see `StabilityTheory`
    kind_of: Callable[[Signals], str]  # kind of a sampled motion, see `StabilityTheory`
    kind: str  # kind of the exact motion
    window: float  # [s] shortest run that shows the kind of motion
    lost: Callable[[StateParts], StableMarks] = lambda state: np.zeros(
        len(state[0]), dtype=bool
    )
    """Function from a state to which runs have diverged, shape (n,)."""

    def nudged(self, steps: Array) -> tuple[SchemeStep, StateParts]:
        """Returns the scheme's step and the nudged initial state, for `steps` [s], shape (n,).

        The nudge is in the imaginary parts: IMAGINARY_STEP times the scales.
        """
        advance, start = self.begin(steps)
        nudges = [*self.scales, *np.zeros(len(start) - len(self.scales))]
        state = []
        for part, nudge in zip(start, nudges, strict=True):
            state.append(np.zeros(len(steps)) + part + 1j * IMAGINARY_STEP * nudge)
        return advance, state

    def size(self, state: StateParts) -> Array:
        """Returns the ratio of the nudge's size in a state to its size at the start, shape (n,);
        infinite for diverged runs."""
        parts = zip(self.names, state, self.scales, strict=False)
        square = sum((part.imag / IMAGINARY_STEP / scale) ** 2 for _, part, scale in parts)
        return np.where(self.lost(state), np.inf, np.sqrt(square / len(self.names)))

    def observed(self, state: StateParts) -> Signals:
        """Returns the observables of a state: the real values of its first parts."""
        return {name: part.real for name, part in zip(self.names, state, strict=False)}


def trial_results(
    motion: SteppedMotion, steps: Array, counts: StepCounts
) -> tuple[StableMarks, StableMarks]:
    """Returns which of `steps` [s] are stable, and which also keep the kind of motion.

    Both results, `steps` and `counts` have shape (n,); `counts` is the number of steps in a run. A
    step is stable if the nudge stays below LOST_GROWTH times the exact motion's growth at all
    times."""
    advance, state = motion.nudged(steps)
    stable = np.ones(len(steps), dtype=bool)
    sample_counts = [0]
    samples: list[Signals] = [motion.observed(state)]
    with np.errstate(all="ignore"):  # diverging runs overflow
        for sample_count in sample_steps(int(counts.max())):
            if not stable.any():
                break
            for n in range(sample_counts[-1], sample_count):
                state = advance(n * steps, state)
            sample_counts.append(sample_count)
            exact_growth = motion.growth(np.minimum(sample_count, counts) * steps)
            excess = motion.size(state) / exact_growth
            stable &= (excess <= LOST_GROWTH) | (sample_count > counts)
            samples.append(motion.observed(state))
    judged = stable & (counts * steps >= motion.window)
    samples_in_run = np.searchsorted(sample_counts, counts, side="right")
    return stable, stable & _keeps_kind(motion, samples, judged, samples_in_run)


def sample_steps(count: int) -> list[int]:
    """Returns the numbers of steps, up to `count`, after which a run is sampled.

    Samples are spaced unevenly, by multiples of the golden ratio: even samples half a period apart
    would show a swing as if it were at rest.
    """
    marks = np.arange(1, NUDGE_SAMPLES + 1)
    marks = marks - (marks * GOLDEN_RATIO) % 1.0
    uneven = np.unique(np.ceil(marks * count / NUDGE_SAMPLES))
    return [int(n) for n in uneven if n < count] + [count]


def _keeps_kind(
    motion: SteppedMotion, samples: Sequence[Signals], judged: StableMarks, counts: StepCounts
) -> StableMarks:
    """Returns which runs keep the exact motion's kind, shape (n,).

    A run's kind is read from its first `counts` samples. Runs that are not `judged` count as kept.
    """
    series = {name: np.stack([sample[name] for sample in samples]) for name in samples[0]}
    keeps_kind = np.ones_like(judged)
    for i in np.flatnonzero(judged):
        run = {name: values[: counts[i], i] for name, values in series.items()}
        keeps_kind[i] = motion.kind_of(run) == motion.kind
    return keeps_kind


def limits_by_steps(motion: SteppedMotion) -> tuple[StepLimit, ...]:
    """Returns the limits of a scheme on a motion.

    If the exact motion itself magnifies a nudge by more than GROWTH_TO_MOTION_SIZE, no limit can be
    found: empty."""
    if float(motion.growth(np.array(LEAST_PERIODS * motion.fastest))) > GROWTH_TO_MOTION_SIZE:
        return ()
    unstable, changed = first_failures(motion)
    limits = []
    rate = math.tau / motion.fastest
    if not math.isnan(unstable):
        why = "a nudge grows a thousandfold beyond the exact motion's growth at"
        limits.append(step_limit("unstable", unstable, why, rate))
    if not changed >= 0.99 * unstable:
        why = f"the motion is no longer {motion.kind} at"
        limits.append(step_limit("changes-kind", changed, why, rate))
    return tuple(limits)


def step_limit(kind: FailureKind, step: float, how: str, rate: float) -> StepLimit:
    """Returns the record of a limit at a `step` [s].

    The step is 0 if every step tried is too large, and infinite if none is. `how` begins the
    reason, such as "the motion is no longer a libration at". The reason goes on with the step as h
    omega, for the motion's fastest `rate` [rad/s].
    """
    if math.isinf(step):
        reason = "no step tried is too large"
    elif step == 0.0:
        reason = f"{how} every step tried"
    else:
        reason = f"{how} h omega = {step * rate:.3g}, the fastest mode's {rate:.3g} rad/s"
    return StepLimit(kind, step, reason)


def first_failures(motion: SteppedMotion) -> tuple[float, float]:
    """Returns the steps [s] below which all steps are stable, and below which all keep the kind.

    A limit is infinite if no step of FIRST_PASS_STEPS fails, and zero if all fail. If the kind
    changes before any step is unstable, the first limit is NaN: the motion that is stable at larger
    steps is another motion. A window of failing steps is missed if it is narrower than the grid's
    factor: 1.13, and 1.04 within STEPS_BELOW_FAILURE of the limit.
    """
    steps = np.geomspace(*FIRST_PASS_STEPS, FIRST_PASS_SIZES) * motion.fastest
    _, keeps_kind = trial_results(
        motion, steps, np.full(FIRST_PASS_SIZES, FIRST_PASS_RUN_STEPS)
    )
    fails = min(_first_failure(steps, keeps_kind)[1], steps[-1])
    unstable, changed = limits_near(motion, fails)
    while changed == 0.0 and fails > steps[0]:
        fails /= TRIAL_STEP_RATIO**STEPS_BELOW_FAILURE
        unstable, changed = limits_near(motion, fails)
    if math.isinf(unstable) and changed < unstable:
        unstable = math.nan
    return unstable, changed


def limits_near(
    motion: SteppedMotion, fails: float, most: int | None = None
) -> tuple[float, float]:
    """Returns the limits of stability and of kind [s] among the steps just below a step that
    `fails` [s].

    The steps go down from `fails` by a factor of TRIAL_STEP_RATIO**STEPS_BELOW_FAILURE. Runs have
    `most` steps; if it is None, `run_length`. A limit is infinite if all steps hold, and zero if
    none does.
    """
    last = exponent(fails / motion.fastest, TRIAL_STRIDE) + TRIAL_STRIDE
    steps = motion.fastest * TRIAL_STEP_RATIO ** np.arange(
        last - STEPS_BELOW_FAILURE, last + 1.0, TRIAL_STRIDE
    )
    counts = run_length(steps, motion.fastest) if most is None else np.full(len(steps), most)
    stable, keeps_kind = trial_results(motion, steps, counts)
    last_stable, first_unstable = _first_failure(steps, stable)
    last_kept, first_changed = _first_failure(steps, keeps_kind)
    return math.sqrt(last_stable * first_unstable), math.sqrt(last_kept * first_changed)


def _first_failure(steps: Array, holds: StableMarks) -> tuple[float, float]:
    """Returns the last step [s] that holds and the first step [s] that fails.

    If the smallest step fails, the last that holds is zero. If all hold, both are infinite.
    """
    failing = np.flatnonzero(~holds)
    if not failing.size:
        return np.inf, np.inf
    first = int(failing[0])
    return float(steps[first - 1]) if first else 0.0, float(steps[first])
