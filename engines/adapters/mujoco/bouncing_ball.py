"""The bouncing ball in MuJoCo's terms: a slide along z, and a contact with spring and damper."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco

from plumbob.analytic.errors.contact_models.impacts import IMPEDANCE, soft_impact
from plumbob.engines.adapters.mujoco.translation import Translation, at_start, read
from plumbob.engines.method import Method


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a BouncingBall; z counts from the height at which the ball touches."""
    spec = whole(mjcf, problem, step)
    radius = spec.geom("ball").size[0]
    return at_start(spec, lambda qpos, qvel: ({"z": qpos[:, 0] - radius}, {}))


def whole(mjcf: Path, problem: Any, step: float = 1e-3) -> mujoco.MjSpec:
    """The model in the file `mjcf` with the numbers of `problem`, and contacts for a `step` [s]."""
    spec = read(mjcf, problem.gravity)
    impact = soft_impact(problem.restitution, step)
    ball = spec.geom("ball")
    ball.solref = impact.solref
    ball.solimp[:2] = [IMPEDANCE, IMPEDANCE]
    spec.key("start").qpos = [problem.height + ball.size[0]]
    return spec
