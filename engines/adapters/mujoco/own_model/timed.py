"""Control periods of a MuJoCo model, stepped for what they cost."""

from __future__ import annotations

import time
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.method import Stepping

WARM = 10  # steps before the time counts: the model's numbers are then in the cache


class TimedPeriods:
    """Some control periods of a compiled model, begun at known states, or where the last one ended
    if that is no number; a `Timed`."""

    compile_seconds = 0.0

    def __init__(self, model: Any, data: Any, starts: Array, controls: Array, parts: int) -> None:
        self.model, self.data, self.parts = model, data, parts
        nq, nv = model.nq, model.nv
        self.starts = [
            None if np.isnan(s).any() else (s[:nq], s[nq : nq + nv], s[nq + nv :]) for s in starts
        ]
        self.controls = controls

    def stepped(self, fraction: float) -> Stepping:
        """The steps of the first `fraction` of the periods."""
        model, data, parts = self.model, self.data, self.parts
        count = max(1, round(fraction * len(self.starts)))
        self._begin(0)
        mujoco.mj_step(model, data, WARM)
        begin = time.thread_time()
        for k in range(count):
            self._begin(k)
            mujoco.mj_step(model, data, parts)
        return Stepping(count * parts, time.thread_time() - begin)

    def _begin(self, k: int) -> None:
        data = self.data
        if (start := self.starts[k]) is not None:
            data.qpos[:], data.qvel[:], data.act[:] = start
        data.ctrl[:] = self.controls[k]
