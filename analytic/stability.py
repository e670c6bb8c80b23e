"""Stability theory on one exact motion: records of largest stable steps and long-run errors."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.schemes import Scheme

# Trial steps, in fastest periods, are powers of TRIAL_STEP_RATIO, both in theory and in measured
# runs. Away from an equilibrium only every fourth power is tried: there some steps fail below
# others that hold.
TRIAL_STEP_RATIO, TRIAL_STRIDE = 1.01, 4
# [fastest periods] smallest and largest trial step
SMALLEST_TRIAL_STEP, LARGEST_TRIAL_STEP = 1e-3, 30.0
# Largest trial step away from an equilibrium, in fastest periods: samples that are further apart do
# not show the kind of motion.
LARGEST_STEP_AWAY = 1.0
# A run is lost if a conserved quantity exceeds this multiple of its scale. Near its stability limit
# a symplectic oscillator's energy swings to 1/(1 - h omega/2) of its start. It reaches 200 times
# the start at 0.995 of the limit, half a bracket below it.
BAND = 200.0
# A run is lost if a nudge grows by more than this multiple of its growth in the exact motion.
LOST_GROWTH = 1e3
FailureKind = Literal["unstable", "changes-kind"]
"""Consequence of a step beyond the limit. "unstable": it magnifies a nudge that the exact motion
does not magnify. "changes-kind": its motion is of another kind (a swing turns over, a well is
left)."""
LoopQuantity = Literal["hold", "delay", "gain"]
"""Quantity of a loop through a digital controller that has a limit: the time for which an answer is
held, its delay, or a factor of all gains."""
LOOP_QUANTITIES: tuple[LoopQuantity, ...] = ("hold", "delay", "gain")
LEVELS = (0.01, 0.1, 1.0)  # ratios of an error to its scale whose times are computed
Growth = Literal["constant", "linear", "quadratic", "exponential", "decaying"]


@dataclass(frozen=True)
class StepLimit:
    """The largest step that holds, and the reason."""

    kind: FailureKind
    step: float  # [s]; infinite if no step is too large
    why: str  # reason: "h omega < 2 of the swing at 3.13 rad/s"


def exponent(periods: float, every: int = 1) -> int:
    """Returns the largest exponent of TRIAL_STEP_RATIO, a multiple of `every`, whose power is at
    most `periods`, a step in fastest periods."""
    exact_exponent = math.log(periods) / math.log(TRIAL_STEP_RATIO)
    return math.floor(exact_exponent / every + 1e-9) * every


NO_STEP = StepLimit("unstable", math.inf, "no step is given: the method chooses its own")


@dataclass(frozen=True)
class LongRun:
    """The growth of a method's error on one motion at one step."""

    growth: Growth  # kind of growth when the error reaches its first level
    rate: float
    """Rate of the growth. If the error is a time ahead, [s/s] for linear and [1/s] for quadratic
    growth. If it is a body's angle, [rad/s] and [rad/s^2]. For exponential growth [1/s]. 0 without
    growth."""
    # [1/s] mean rate of the ratio of the energy to its scale; 0 if the energy is bounded
    energy_rate: float
    times: Mapping[float, float]
    """Time [s] at which the error first reaches each level. If the part of the error that repeats
    in each period reaches the level, the time is close to zero; if the error never does, it is
    infinite."""


def no_long_run(scheme: Scheme, step: float, scales: Mapping[str, float]) -> LongRun | None:
    """Returns None: there is no prediction for any scheme."""
    return None


@dataclass(frozen=True)
class StabilityTheory:
    """Limits of steps on one exact motion, and the properties by which a run of it is judged."""

    fastest: float  # [s] shortest period of the linearised motion, or its time constant
    equilibrium: bool  # whether it stays near an equilibrium: eigenvalues alone set the limit
    limits: Callable[[Scheme], tuple[StepLimit, ...]]
    """Function from a scheme to its limits, the unstable one first. If no limit is known, there are
    none. If the kind changes at much smaller steps, the unstable limit is left out. A limit of zero
    means that no trial step holds."""
    growth: Callable[[float], float]
    """Function from a duration [s] to the largest factor by which the exact motion magnifies a
    nudge of its start, at least 1. A nudge is a change of the state over the state's scales."""
    kind_of: Callable[[Signals], str]
    """Function from sampled observables to the kind of motion: "libration", "rotation", ..."""
    long_run: Callable[[Scheme, float, Mapping[str, float]], LongRun | None] = no_long_run
    """Function from a scheme, a step [s] and the scales of observables to the growth of the error;
    None if the growth is not known."""
    energy: Callable[[Signals], Array] | None = None
    """Function from sampled observables to the ratio of the energy to its scale, shape (n,); None
    if the energy is not conserved."""
    lasts: float = math.inf  # [s] time until a damped motion rests, or a forced one repeats
