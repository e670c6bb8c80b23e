"""The number of steps of a run, the steps that are kept as samples, and a check that a run kept
them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from plumbob.analytic.parameters import ParameterError, positive
from plumbob.engines.trajectory import Trajectory

Indices = npt.NDArray[np.int64]
MAX_SAMPLES = 500  # largest number of samples: enough for a smooth curve
MAX_SAMPLED_STEPS = 1_000_000_000  # largest number of steps: half an hour at the cheapest step
# Allowed error of a sample's time, as a fraction of the step. A sum of 10^6 steps rounds a time by
# a tenth of that at most.
CLOCK = 1e-3
# Allowed error of the last time of a solver that chooses its steps, as a fraction of the duration
CLOCK_OF_A_SOLVER = 1e-9


def step_count(duration: float, step: float) -> int:
    """The number of whole steps [s] whose sum is nearest to `duration` [s]. Raises ParameterError
    for a step that is not positive, exceeds the duration, or would need more than
    `MAX_SAMPLED_STEPS`."""
    positive("step", step)
    if step > duration:
        raise ParameterError("step", step, f"at most the duration, {duration} s")
    if step * MAX_SAMPLED_STEPS < duration:
        raise ParameterError(
            "step", step, f"at least {duration / MAX_SAMPLED_STEPS} s for this duration"
        )
    return round(duration / step)


def first_step_count(steps: int, fraction: float) -> int:
    """The number of steps in the first `fraction` of `steps`, at least one."""
    return max(1, round(steps * fraction))


def stride(steps: int, samples: int = MAX_SAMPLES) -> int:
    """The number of steps from one sample to the next, with which at most `samples` cover
    `steps`."""
    return max(1, -(-steps // samples))


def sampled(steps: int, samples: int = MAX_SAMPLES) -> Indices:
    """The numbers of the steps that are kept: 0, every `stride`-th, and the last."""
    return np.append(np.arange(0, steps, stride(steps, samples), dtype=np.int64), steps)


def cut_short(run: Trajectory, duration: float, step: float | None) -> str:
    """Returns why a run that claims to have ended is not a run of `duration` [s] with steps of
    `step` [s], or with steps that the solver chooses if `step` is None. The text is empty if the
    run is."""
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
        counted = isinstance(run.steps, int | np.integer) and 0 < run.steps <= MAX_SAMPLED_STEPS
        return (
            ""
            if counted
            else f"it counts {run.steps} evaluations, not 1 to {MAX_SAMPLED_STEPS:g}"
        )
    kept = sampled(steps) * step
    if len(kept) != len(times) or np.abs(times - kept).max() > clock:
        return f"its {len(times)} samples are not those at the {len(kept)} times asked for"
    return "" if run.steps == steps else f"it counts {run.steps} steps, and takes {steps}"
