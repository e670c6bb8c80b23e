"""How many steps a run takes, which of them are kept as samples, and whether a run kept them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from plumbob.analytic.parameters import ParameterError, positive
from plumbob.engines.trajectory import Trajectory

Indices = npt.NDArray[np.int64]
SAMPLES = 500  # enough for a smooth curve; the errors are judged at the samples
MOST_STEPS = 1_000_000_000  # half an hour at the cheapest step of any engine
# Of a step: adding up 10^6 steps rounds a time by a tenth of that at most; of the duration, for a
# solver that chooses its steps, what adding up as many rounds.
CLOCK, CLOCK_OF_A_SOLVER = 1e-3, 1e-9


def step_count(duration: float, step: float) -> int:
    """Number of whole steps [s] nearest to `duration` [s]; raises ParameterError for a step that is
    not positive, exceeds the duration, or would need more than a thousand million steps."""
    positive("step", step)
    if step > duration:
        raise ParameterError("step", step, f"at most the duration, {duration} s")
    if step * MOST_STEPS < duration:
        raise ParameterError(
            "step", step, f"at least {duration / MOST_STEPS} s for this duration"
        )
    return round(duration / step)


def first_steps(steps: int, fraction: float) -> int:
    """Number of steps in the first `fraction` of `steps`, one at least."""
    return max(1, round(steps * fraction))


def stride(steps: int, samples: int = SAMPLES) -> int:
    """Steps from one sample to the next, so that at most `samples` cover `steps`."""
    return max(1, -(-steps // samples))


def sampled(steps: int, samples: int = SAMPLES) -> Indices:
    """Indices of the steps kept: 0, every `stride`-th, and always the last."""
    return np.append(np.arange(0, steps, stride(steps, samples), dtype=np.int64), steps)


def cut_short(run: Trajectory, duration: float, step: float | None) -> str:
    """Why a run that claims to have ended is not the one asked for, of `duration` [s] at `step` [s]
    (None: of a solver that chooses its steps); empty where it is."""
    times = run.times
    steps = step_count(duration, step) if step else 0
    end = duration
    clock = CLOCK_OF_A_SOLVER * duration
    if step:
        end = steps * step
        clock = CLOCK * step
    if len(times) < 2 or times[0] != 0.0 or not (np.diff(times) > 0.0).all():
        return f"its {len(times)} times do not increase from 0"
    if not abs(times[-1] - end) <= clock:
        return f"it ends at {times[-1]:g} s of {end:g} s"
    if not step:
        counted = isinstance(run.steps, int | np.integer) and 0 < run.steps <= MOST_STEPS
        return "" if counted else f"it counts {run.steps} evaluations, not 1 to {MOST_STEPS:g}"
    kept = sampled(steps) * step
    if len(kept) != len(times) or np.abs(times - kept).max() > clock:
        return f"its {len(times)} samples are not those at the {len(kept)} times asked for"
    return "" if run.steps == steps else f"it counts {run.steps} steps, and takes {steps}"
