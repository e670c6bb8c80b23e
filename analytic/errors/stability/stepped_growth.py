"""Growth of a nudge, and changes of the kind of motion, along steps of many sizes at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plumbob.analytic.errors.smooth_motion.scheme_steps import Advance, Parts
from plumbob.analytic.errors.stability.flow_growth import LOST
from plumbob.analytic.errors.stability.largest_step import (
    LEAST_PERIODS,
    Marks,
    run_length,
)
from plumbob.analytic.numerics.smooth.smooth_system import TINY
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.stability import (
    AWAY,
    EVERY,
    LOST_GROWTH,
    RATIO,
    Kind,
    StepLimit,
    exponent,
)

SAMPLES = 256  # along a run, of nudge and kind
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
COARSE = 48  # step sizes of the first pass
SHORT = 1000  # steps of the first
BELOW = 140  # exponents of RATIO, a factor of 4: below what fails first the second looks, too
RANGE = (0.02 / math.tau, AWAY)  # in fastest periods
Counts = npt.NDArray[np.int64]


@dataclass(frozen=True)
class SteppedMotion:
    """One exact motion, and a scheme's steps on it."""

    begin: Callable[[Array], tuple[Advance, Parts]]
    """Of steps [s], shape (n,): the step, of a time and of the parts of a state, shape (n,) each,
    and the state that it begins with."""
    names: Sequence[str]  # of a state's first parts, which are observed
    scales: Sequence[float]  # of the first parts, which are nudged by as much
    fastest: float  # [s]
    growth: Callable[[Array], Array]  # of the exact motion, see `StabilityTheory`
    kind_of: Callable[[Signals], str]
    kind: str  # of the exact motion
    window: float  # [s] the shortest time in which it shows
    lost: Callable[[Parts], Marks] = lambda state: np.zeros(len(state[0]), dtype=bool)
    """Which steps have left all that the motion conserves."""

    def nudged(self, steps: Array) -> tuple[Advance, Parts]:
        """The step and the start for steps [s], shape (n,), with the nudge, TINY of the scales, in
        imaginary parts."""
        advance, start = self.begin(steps)
        nudges = [*self.scales, *np.zeros(len(start) - len(self.scales))]
        return advance, [
            np.zeros(len(steps)) + part + 1j * TINY * nudge
            for part, nudge in zip(start, nudges, strict=True)
        ]

    def size(self, state: Parts) -> Array:
        """Size of the nudge in a state over that at the start, infinite where it is lost."""
        parts = zip(self.names, state, self.scales, strict=False)
        squares = sum((part.imag / TINY / scale) ** 2 for _, part, scale in parts)
        return np.where(self.lost(state), np.inf, np.sqrt(squares / len(self.names)))

    def observed(self, state: Parts) -> Signals:
        """Its first parts."""
        return {name: part.real for name, part in zip(self.names, state, strict=False)}


def tried(motion: SteppedMotion, steps: Array, counts: Counts) -> tuple[Marks, Marks]:
    """Which of `steps` [s], shape (n,), hold for so many steps: magnify the nudge by less than
    LOST_GROWTH times the exact motion's growth at every time, and keep the kind of motion."""
    advance, state = motion.nudged(steps)
    stable = np.ones(len(steps), dtype=bool)
    counted = [0]
    samples: list[Signals] = [motion.observed(state)]
    with np.errstate(all="ignore"):  # of steps that diverge
        for sampled in sampled_steps(int(counts.max())):
            if not stable.any():
                break
            for n in range(counted[-1], sampled):
                state = advance(n * steps, state)
            counted.append(sampled)
            over = motion.size(state) / motion.growth(np.minimum(sampled, counts) * steps)
            stable &= (over <= LOST_GROWTH) | (sampled > counts)
            samples.append(motion.observed(state))
    judged = stable & (counts * steps >= motion.window)
    within = np.searchsorted(counted, counts, side="right")
    return stable, stable & _kept(motion, samples, judged, within)


def sampled_steps(count: int) -> list[int]:
    """The steps, up to `count`, after which a run is sampled: unevenly, by parts of the golden
    ratio, since even samples half a period apart show a swing at rest."""
    marks = np.arange(1, SAMPLES + 1)
    marks = marks - (marks * GOLDEN) % 1.0
    return [int(n) for n in np.unique(np.ceil(marks * count / SAMPLES)) if n < count] + [count]


def _kept(
    motion: SteppedMotion, samples: Sequence[Signals], judged: Marks, counts: Counts
) -> Marks:
    """Which motions keep their kind in so many of the samples, of those that are judged."""
    series = {name: np.stack([sample[name] for sample in samples]) for name in samples[0]}
    kept = np.ones_like(judged)
    for i in np.flatnonzero(judged):
        kind = motion.kind_of({name: values[: counts[i], i] for name, values in series.items()})
        kept[i] = kind == motion.kind
    return kept


def limits_by_steps(motion: SteppedMotion) -> tuple[StepLimit, ...]:
    """The limits of a scheme; empty where the exact motion magnifies a nudge too much to tell."""
    if float(motion.growth(np.array(LEAST_PERIODS * motion.fastest))) > LOST:
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


def step_limit(kind: Kind, step: float, how: str, rate: float) -> StepLimit:
    """A limit that is a `step` [s], beside the fastest `rate` [rad/s] of the motion."""
    at = f"{how} h omega = {step * rate:.3g}, the fastest mode's {rate:.3g} rad/s"
    if math.isinf(step):
        at = "no step tried is too large"
    return StepLimit(kind, step, at if step else f"{how} every step tried")


def first_failures(motion: SteppedMotion) -> tuple[float, float]:
    """The steps [s] below which all smaller ones are stable, and keep their kind; infinite where
    none of RANGE fails, zero where all do. The first is NaN where the kind changes before it: what
    is stable then is another motion. Windows of failure narrower than the grid's factor are missed:
    1.13, and 1.04 within BELOW of the limit."""
    steps = np.geomspace(*RANGE, COARSE) * motion.fastest
    kept = tried(motion, steps, np.full(COARSE, SHORT))[1]
    fails = min(_first(steps, kept)[1], steps[-1])
    unstable, changed = near(motion, fails)
    while changed == 0.0 and fails > steps[0]:
        fails /= RATIO**BELOW
        unstable, changed = near(motion, fails)
    return math.nan if changed < unstable == math.inf else unstable, changed


def near(motion: SteppedMotion, fails: float, most: int | None = None) -> tuple[float, float]:
    """The limits among the steps up to `fails` [s] and BELOW smaller ones, of runs of `most` steps
    or of their full length: infinite where all hold, zero where none does."""
    last = exponent(fails / motion.fastest, EVERY) + EVERY
    steps = motion.fastest * RATIO ** np.arange(last - BELOW, last + 1.0, EVERY)
    counts = run_length(steps, motion.fastest) if most is None else np.full(len(steps), most)
    unstable, changed = (_first(steps, marks) for marks in tried(motion, steps, counts))
    return math.sqrt(unstable[0] * unstable[1]), math.sqrt(changed[0] * changed[1])


def _first(steps: Array, held: Marks) -> tuple[float, float]:
    """The last step [s] that holds before one that does not, zero where none does, and that one;
    infinite where all hold."""
    failing = np.flatnonzero(~held)
    if not failing.size:
        return np.inf, np.inf
    first = int(failing[0])
    return float(steps[first - 1]) if first else 0.0, float(steps[first])
