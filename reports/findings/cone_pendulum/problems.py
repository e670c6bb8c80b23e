"""The cone pendulum's problems that the findings share."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of

RESTING, ROTATING = "cone-pendulum/resting-base", "cone-pendulum/rotating-base"
MUJOCO, MUJOCO_STEP = "mujoco/rk4", 1e-4  # its full model: platform, hinge and cone
LAGRANGE, LAGRANGE_RTOL = "ode/dop853", 1e-13  # eq. 7's equation of motion, integrated
BLUE, RED, BLACK, PINK = "#0072b2", "#d55e00", "#808080", "#cc79a7"


@dataclass(frozen=True)
class Case:
    """A scene's problem with both of its motions, whose tables take a tenth of a second each."""

    problem: ConePendulum
    correct: PendulumMotion
    printed: PendulumMotion  # of eqs. 9, 15 and 16


@cache
def case(name: str) -> Case:
    """The problem of a scene, and its motions."""
    chosen = find_scene(name)
    problem: ConePendulum = system_of(chosen).problem(chosen.parameters)
    return Case(problem, problem.motion, problem.printed_motion())
