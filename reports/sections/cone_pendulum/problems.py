"""The cone pendulum's problems and runs that the findings share."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from analytic.arithmetic.quad import double
from analytic.cone_pendulum import ConePendulum
from analytic.elliptic.trigonometric_potential import TrigonometricPotential
from analytic.pendulums.pendulum_motion import PendulumMotion
from analytic.reference import Array
from engines.registry import engine_of, installed
from engines.registry import method as find_method
from engines.trajectory import Trajectory
from models.registry import scene as find_scene
from models.registry import system_of

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


def run(name: str, method: str, step: float, duration: float | None = None) -> Trajectory | None:
    """Run a scene, for `duration` [s] where that is given; None where the engine is missing, or
    the run does not reach the end."""
    chosen, how = find_scene(name), find_method(method)
    if duration is not None:
        chosen = replace(chosen, duration=duration)
    if not installed(engine_of(how)):
        return None
    found = engine_of(how).prepare(system_of(chosen), chosen, how, step).run()
    return found if found.diverged_at is None else None


def in_double(potential: TrigonometricPotential) -> TrigonometricPotential:
    """The potential with coefficients in double precision."""
    return TrigonometricPotential(
        *(float(double(v)) for v in (potential.a, potential.b, potential.c))
    )


def energy(problem: ConePendulum, potential: TrigonometricPotential, run: Trajectory) -> Array:
    """I_x theta_dot^2 / 2 + `potential` [J] along a run, shape (n,)."""
    theta, rate = run.observables["theta"], run.observables["theta_dot"]
    kinetic = problem.body.inertia_x * rate**2 / 2
    return np.asarray(kinetic + in_double(potential).value(theta))
