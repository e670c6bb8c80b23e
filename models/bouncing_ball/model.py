"""The numbers of a bouncing ball in bouncing_ball.xml, and its idealisation."""

from __future__ import annotations

from typing import Any

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.bouncing_ball import BouncingBall
from plumbob.models.idealisations import Idealisations
from plumbob.models.model_file import ModelFile

RADIUS = 0.1  # [m] of the ball in the file


def fill(spec: Any, problem: BouncingBall) -> None:
    """Write the numbers of a ball into an MjSpec of bouncing_ball.xml, all but the spring and the
    damper of its contact, which go with the step."""
    spec.option.gravity = [0.0, 0.0, -problem.gravity]
    spec.key("start").qpos = [problem.height + RADIUS]


def ideal(problem: BouncingBall) -> Idealisations:
    """The ball bounces."""
    return Idealisations(restitution={"ball": problem.restitution})


def observe(problem: BouncingBall, qpos: Array, qvel: Array) -> Signals:
    """The height of the ball's lowest point above the floor."""
    return {"z": qpos[:, 0] - RADIUS}


MODEL = ModelFile(fill, observe, ideal)
