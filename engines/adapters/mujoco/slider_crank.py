"""The slider-crank in MuJoCo's terms: crank and rod as a tree, tied to the slider softly."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import Scheme, SoftLoop
from plumbob.engines.adapters.mujoco.translation import (
    Observed,
    Translation,
    at_start,
    bare,
    filled,
    solved_loop,
)
from plumbob.engines.method import Method, ModelError
from plumbob.models.slider_crank.model import fill

# of the file's solref and solimp: the stiffest for a step of 1 ms
LOOP = SoftLoop(2e-3, 0.9999)


def scheme(method: Method) -> Scheme:
    """The scheme of `method`, on a loop that is closed softly."""
    return replace(method.scheme, loop=LOOP)


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a SliderCrank."""
    stretched = problem.crank + problem.rod

    def observe(qpos: Array, qvel: Array) -> Observed:
        state = {"angle": qpos[:, 0], "angle_dot": qvel[:, 0], "slider": stretched + qpos[:, 2]}
        return state, {}

    return at_start(bare(filled(mjcf, fill, problem)), observe)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """The arithmetic of the solver; the soft constraint itself is part of the step."""
    angle = solved_loop(problem.motion, LOOP, duration)
    return {"angle": angle, "slider": {why: 2 * problem.crank * e for why, e in angle.items()}}
