"""Steps control periods of a MuJoCo model to measure the cost of a step."""

from __future__ import annotations

import time
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.terms import put
from plumbob.engines.method import Stepping

WARM = 10  # steps before the time counts, to warm up the solver and the cache


class TimedPeriods:
    """A `TimedSimulation` of some control periods of a compiled model. Each period begins at its
    known state or, if that is nan, where the last period ended."""

    compile_seconds = 0.0

    def __init__(
        self, model: Any, data: Any, starts: Array, controls: Array, steps: int
    ) -> None:
        self.model, self.data, self.steps, self.controls = model, data, steps, controls
        self.starts: list[Any] = [None if np.isnan(start).any() else start for start in starts]

    def stepped(self, fraction: float) -> Stepping:
        """Takes the steps of the first `fraction` of the periods."""
        model = self.model
        data = self.data
        spent = 0.0
        count = max(1, round(fraction * len(self.starts)))
        begin = time.thread_time()
        for start, control in zip(self.starts[:count], self.controls, strict=False):
            data.ctrl[:] = control
            if start is not None:
                spent += time.thread_time() - begin
                put(data, start)
                mujoco.mj_step(model, data, WARM)
                begin = time.thread_time()
            mujoco.mj_step(model, data, self.steps)
        return Stepping(count * self.steps, spent + time.thread_time() - begin)
