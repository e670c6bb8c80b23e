"""The slider-crank in MuJoCo's terms: crank and rod as a tree, tied to the slider softly."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco

from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import Scheme, SoftLoop
from plumbob.engines.adapters.mujoco.translation import (
    Observed,
    Translation,
    at_start,
    bare,
    read,
    solved_loop,
)
from plumbob.engines.method import Method, ModelError

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

    return at_start(bare(whole(mjcf, problem)), observe)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """The arithmetic of the solver; the soft constraint itself is part of the step."""
    angle = solved_loop(problem.motion, LOOP, duration)
    return {"angle": angle, "slider": {why: 2 * problem.crank * e for why, e in angle.items()}}


def whole(mjcf: Path, problem: Any) -> mujoco.MjSpec:
    """The model in the file `mjcf` with the numbers of `problem`, visual parts included."""
    spec = read(mjcf, problem.gravity)
    stretched = problem.crank + problem.rod
    for name in ("crank", "rod"):
        link, length, mass = (
            spec.body(name),
            *(getattr(problem, n) for n in (name, f"{name}_mass")),
        )
        link.mass = mass
        link.ipos = [length / 2, 0.0, 0.0]
        link.inertia = [mass * length**2 / 12] * 3
        spec.geom(name).fromto = [0.0, 0.0, 0.0, length, 0.0, 0.0]
    spec.body("rod").pos = [problem.crank, 0.0, 0.0]
    spec.body("slider").pos = [stretched, 0.0, 0.0]
    spec.body("slider").mass = problem.slider_mass
    pin = spec.equality("pin")
    pin.data = [problem.rod, 0.0, 0.0, *pin.data[3:]]
    start = spec.key("start")
    opened = problem.opened
    for name, (crank, rod, slider) in {"qpos": opened.position, "qvel": opened.rate}.items():
        away = stretched if name == "qpos" else 0.0
        setattr(start, name, [crank, rod - crank, slider - away])
    return spec
