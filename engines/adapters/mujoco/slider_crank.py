"""The slider-crank in MuJoCo: crank and rod are a tree, tied to the slider by a soft constraint."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from plumbob.analytic.schemes import Scheme, SoftLoop
from plumbob.engines.adapters.mujoco.translation import solved_loop
from plumbob.engines.method import Method, ModelError

# the constraint as the model file's solref and solimp have it: the stiffest for a step of 1 ms
LOOP = SoftLoop(2e-3, 0.9999)


def scheme(method: Method) -> Scheme:
    """The scheme of `method` on a loop that a soft constraint closes."""
    return replace(method.scheme, loop=LOOP)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Bounds on the rounding of the solver. The softness of the constraint is part of the
    scheme."""
    angle = solved_loop(problem.motion, LOOP, duration)
    slider = {reason: 2 * problem.crank * bound for reason, bound in angle.items()}
    return {"angle": angle, "slider": slider}
