"""The relation of a bouncing ball to bouncing_ball.xml."""

from __future__ import annotations

from typing import Any

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.bouncing_ball import BouncingBall
from plumbob.models.idealisations import Idealisations
from plumbob.models.model_file import ModelFile

RADIUS = 0.1  # [m] radius of the ball in the file


def fill(spec: Any, problem: BouncingBall) -> None:
    """Writes the numbers of a ball into an MjSpec of bouncing_ball.xml, but not the spring and the
    damper of its contact: these depend on the step."""
    spec.option.gravity = [0.0, 0.0, -problem.gravity]
    spec.key("start").qpos = [problem.height + RADIUS]


def ideal(problem: BouncingBall) -> Idealisations:
    """Returns the idealisation: the ball bounces."""
    return Idealisations(restitution={"ball": problem.restitution})


def observe(problem: BouncingBall, qpos: Array, qvel: Array) -> Signals:
    """Returns the height of the ball's lowest point above the floor."""
    return {"z": qpos[:, 0] - RADIUS}


MODEL = ModelFile(fill, observe, ideal)
