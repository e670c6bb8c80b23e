"""A controller that samples a run in steps: the steps at which it is asked, and its answers act."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

# A time this close to the begin of a step, in steps, is at it: multiples of a step are rounded.
AT_BEGIN = 1e-6


@dataclass(frozen=True)
class SamplingTimes:
    """A controller samples every `hold` [s], the first time at 0, and its answers act `delay` [s]
    later. A run in steps takes a sample, and lets an answer act, at the first step that begins at
    that time or later."""

    hold: float
    delay: float = 0.0

    def sampled_at(self, sample: int, step: float) -> int:
        """Returns the number of the step [s] at whose begin a sample is taken."""
        return math.ceil(sample * self.hold / step - AT_BEGIN)

    def acts_from(self, sample: int, step: float) -> int:
        """Returns the number of the first step [s] in which the answer to a sample acts."""
        return math.ceil((sample * self.hold + self.delay) / step - AT_BEGIN)


class HeldAnswers:
    """The answers of a controller during one run in steps of `step` [s]. `ask` takes the time [s]
    of a sample, and returns the answer to the present state of the run. `idle` acts before the
    first answer does."""

    def __init__(
        self, times: SamplingTimes, step: float, ask: Callable[[float], Any], idle: Any
    ) -> None:
        self.times, self.step, self.ask = times, step, ask
        self.acting = idle
        self.answers: dict[int, Any] = {}
        self.samples = 0  # number of samples that are taken
        self.acted = 0  # number of answers that have begun to act

    def parts(self, first: int, last: int) -> Iterator[tuple[Any, int]]:
        """Yields each answer that acts in the steps from `first` to `last`, and the number of steps
        in which it acts. The caller takes these steps before it asks for the next part."""
        times = self.times
        step = self.step
        while first < last:
            while times.sampled_at(self.samples, step) <= first:
                self.answers[self.samples] = self.ask(self.samples * times.hold)
                self.samples += 1
            while times.acts_from(self.acted, step) <= first:
                self.acting = self.answers.pop(self.acted)
                self.acted += 1
            changes = times.sampled_at(self.samples, step), times.acts_from(self.acted, step)
            end = min(last, *changes)
            yield self.acting, end - first
            first = end
