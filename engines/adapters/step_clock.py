"""The times of the steps that an engine takes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array


@dataclass
class StepClock:
    """Counts the steps that a stepper takes from the time at which its state was put."""

    step: float  # [s]
    start: float = 0.0  # [s] time at which the state was put
    steps_taken: int = 0

    def restart(self, time: float) -> None:
        """Begins to count steps from a time [s]."""
        self.start = time
        self.steps_taken = 0

    def next_numbers(self, steps: int) -> Array:
        """The number of steps taken so far, and after each of the next `steps` steps, shape (steps
        + 1,)."""
        return np.arange(self.steps_taken, self.steps_taken + steps + 1, dtype=np.float64)

    def next_times(self, steps: int) -> Array:
        """The present time, and the times at the ends of the next `steps` steps [s], shape (steps +
        1,)."""
        return self.start + self.step * self.next_numbers(steps)
