"""Records of theory about one exact motion: largest steps that hold, and errors of long runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.schemes import Scheme

# Steps that are tried are powers of RATIO, in fastest periods, of theory and of runs alike; away
# from an equilibrium, where single steps fail below others that hold, those of every fourth power.
RATIO, EVERY = 1.01, 4
SMALLEST, LARGEST = 1e-3, 30.0  # in fastest periods
AWAY = 1.0  # the largest away from an equilibrium: samples farther apart show no kind of motion
# Of a conserved quantity, in its own scale: a run that leaves it is lost. Near its limit a
# symplectic oscillator's energy swings to 1/(1 - h omega/2) of its start: to 200 times that at
# 0.995 of the limit, half a bracket below.
BAND = 200.0
# A nudge may grow so many times as much as it grows in the exact motion: more is lost.
LOST_GROWTH = 1e3
Kind = Literal["unstable", "changes-kind"]
"""Consequence of a step beyond the limit: it magnifies a nudge that the exact motion does not, or
its motion becomes one of another kind (a swing turns over, a well is left)."""
LEVELS = (0.01, 0.1, 1.0)  # of an error over its scale, whose times are asked for
Growth = Literal["constant", "linear", "quadratic", "exponential", "decaying"]


@dataclass(frozen=True)
class StepLimit:
    """The largest step that holds, and what sets it."""

    kind: Kind
    step: float  # [s]; infinite where no step is too large
    why: str  # "h omega < 2 of the swing at 3.13 rad/s"


def exponent(periods: float, every: int = 1) -> int:
    """The largest exponent of RATIO, a multiple of `every`, at which a step is no larger than so
    many fastest periods."""
    return math.floor(math.log(periods) / math.log(RATIO) / every + 1e-9) * every


NO_STEP = StepLimit("unstable", math.inf, "no step is given: the method chooses its own")


@dataclass(frozen=True)
class LongRun:
    """The growth of a method's error on one motion at one step."""

    growth: Growth  # at the time of the first level that is reached
    rate: float
    """Of the time ahead, [s/s] where linear and [1/s] where quadratic; of a body's angle, [rad/s]
    and [rad/s^2]; [1/s] of an exponential; 0 where it does not grow."""
    energy_rate: float  # [1/s] mean rate of the energy over its scale; 0: bounded
    times: Mapping[float, float]
    """[s] by level, when the error first reaches it: next to zero where the part that repeats
    alone does, infinite where it never does."""


def no_long_run(scheme: Scheme, step: float, scales: Mapping[str, float]) -> LongRun | None:
    """No prediction, of any scheme."""
    return None


@dataclass(frozen=True)
class StabilityTheory:
    """Limits of steps on one exact motion, and what a run of that motion is held to."""

    fastest: float  # [s] the shortest period of the linearised motion, or its time constant
    equilibrium: bool  # stays by an equilibrium, where eigenvalues alone set the limit
    limits: Callable[[Scheme], tuple[StepLimit, ...]]
    """The limits of a scheme, unstable first; empty where none is known, and without that one
    where the kind changes long before. A step of zero: no step that was tried holds."""
    growth: Callable[[float], float]
    """The largest factor by which the exact motion magnifies a nudge of its start within a duration
    [s], in the state divided by its scales; at least 1."""
    kind_of: Callable[[Signals], str]
    """The kind of motion of sampled observables: "libration", "rotation", "at rest", ..."""
    long_run: Callable[[Scheme, float, Mapping[str, float]], LongRun | None] = no_long_run
    """The growth of the error of a scheme at a step [s], of observables over these scales; None
    where nothing is known of it."""
    energy: Callable[[Signals], Array] | None = None
    """Energy over its scale of sampled observables, shape (n,); None where it is not conserved."""
    lasts: float = math.inf  # [s] until a damped motion is at rest, or a forced one repeats
