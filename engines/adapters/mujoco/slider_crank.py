"""The slider-crank in MuJoCo: crank and rod as a tree, tied to the slider softly."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from plumbob.analytic.schemes import Scheme, SoftLoop
from plumbob.engines.adapters.mujoco.translation import solved_loop
from plumbob.engines.method import Method, ModelError

# of the file's solref and solimp: the stiffest for a step of 1 ms
LOOP = SoftLoop(2e-3, 0.9999)


def scheme(method: Method) -> Scheme:
    """The scheme of `method`, on a loop that is closed softly."""
    return replace(method.scheme, loop=LOOP)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """The arithmetic of the solver; the soft constraint itself is part of the step."""
    angle = solved_loop(problem.motion, LOOP, duration)
    return {"angle": angle, "slider": {why: 2 * problem.crank * e for why, e in angle.items()}}
