"""The linear pendulum in MuJoCo's terms: the simple one's hinge, a spring in place of gravity."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco

from plumbob.analytic.systems.pendulums.rod_tension import MASS
from plumbob.engines.adapters.mujoco import simple_pendulum
from plumbob.engines.adapters.mujoco.translation import Translation
from plumbob.engines.method import Method


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a linear simple_pendulum.SimplePendulum: nothing pulls along its rod."""
    built = simple_pendulum.build(mjcf, problem, method, step)
    _sprung(built.spec, problem)
    built.spec.delete(built.spec.sensor("rod"))
    return replace(built, felt=None)


def whole(mjcf: Path, problem: Any) -> mujoco.MjSpec:
    """The model in the file `mjcf` with the numbers of `problem`, what is only seen included."""
    spec = simple_pendulum.whole(mjcf, problem)
    _sprung(spec, problem)
    return spec


def model_error(
    problem: Any, duration: float, method: Method, step: float
) -> Mapping[str, Mapping[str, float]]:
    """What the bob's moment of inertia adds, as for the simple pendulum."""
    return simple_pendulum.model_error(problem, duration, method, step)


def _sprung(spec: mujoco.MjSpec, problem: Any) -> None:
    spec.option.gravity = [0.0, 0.0, 0.0]
    joint, stiffness = spec.joint("theta"), MASS * problem.gravity * problem.length
    joint.stiffness = simple_pendulum.first_coefficient(joint.stiffness, stiffness)
