"""The relation of a rolling ball to rolling_ball.xml."""

from __future__ import annotations

from typing import Any

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.rolling_ball import RollingBall
from plumbob.models.model_file import ModelFile


def fill(spec: Any, problem: RollingBall) -> None:
    """Writes the numbers of a ball into an MjSpec of rolling_ball.xml."""
    radius = problem.radius
    ball = spec.body("ball")
    pair = spec.pair("contact")
    spec.option.gravity = [0.0, 0.0, -problem.gravity]
    ball.pos = [0.0, 0.0, radius]
    ball.mass = problem.mass
    ball.inertia = [0.4 * problem.mass * radius**2] * 3
    spec.geom("ball").size[0] = radius
    sliding = problem.friction
    torsional = problem.torsional_friction
    rolling = problem.rolling_friction
    pair.friction = [sliding, sliding, torsional, rolling, rolling]
    # MuJoCo raises an active coefficient to at least 1e-5, so dimensions without friction are left
    # out.
    pair.condim = 4 if torsional else 3
    if rolling:
        pair.condim = 6
    elif not sliding:
        pair.condim = 1
    spec.key("start").qvel = [problem.speed, 0.0, problem.spin]


def observe(problem: RollingBall, qpos: Array, qvel: Array) -> Signals:
    """Returns the place, the speed and the spin."""
    return {"x": qpos[:, 0], "speed": qvel[:, 0], "spin": qvel[:, 2]}


MODEL = ModelFile(fill, observe)
