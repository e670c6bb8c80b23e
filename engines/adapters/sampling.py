"""How many steps a run takes, and which of them are kept as samples."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from plumbob.analytic.parameters import ParameterError, positive

Indices = npt.NDArray[np.int64]
SAMPLES = 500  # enough for a smooth curve; the errors are judged at the samples
MOST_STEPS = 1_000_000_000  # half an hour at the cheapest step of any engine


def step_count(duration: float, step: float) -> int:
    """Number of whole steps [s] nearest to `duration` [s]; raises ParameterError for a step that is
    not positive, exceeds the duration, or would need more than a thousand million steps."""
    positive("step", step)
    if step > duration:
        raise ParameterError("step", step, f"at most the duration, {duration} s")
    if step * MOST_STEPS < duration:
        raise ParameterError("step", step, f"at least {duration / MOST_STEPS} s for this duration")
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
