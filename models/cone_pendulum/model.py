"""The relation of a cone pendulum to cone_pendulum.xml."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from plumbob.analytic.parameters import finite
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.cone_pendulum import Body, ConePendulum
from plumbob.models.idealisations import Idealisations
from plumbob.models.largest import largest_pendulum_rates
from plumbob.models.model_file import ModelFile
from plumbob.models.simple_pendulum.model import hinge_angle

PLATFORM_RATIO = 1e15  # ratio of the platform's moment of inertia to its load's


def fill(spec: Any, problem: ConePendulum) -> None:
    """Writes the numbers of a cone pendulum into an MjSpec of cone_pendulum.xml. The platform gets
    an armature that is large enough to keep its rate to the last bit."""
    pendulum = problem.started
    body = pendulum.body
    cone = spec.body("cone")
    start = spec.key("start")
    moments = moments_about_centre(body)
    spec.option.gravity = [0.0, 0.0, -pendulum.gravity]
    spec.joint("platform").armature = holding_inertia(pendulum)
    cone.pos = [pendulum.pivot_x, pendulum.pivot_y, pendulum.pivot_z]
    cone.mass = body.mass
    cone.ipos = [0.0, 0.0, -body.com_distance]
    cone.inertia = np.diag(moments)
    # With `fullinertia` MuJoCo computes the principal axes.
    product = moments[1, 2]
    if product:
        cone.inertia = [0.0, 0.0, 0.0]
        cone.fullinertia = [*np.diag(moments), 0.0, 0.0, product]
    start.qpos = [0.0, finite("theta", pendulum.theta)]
    start.qvel = [pendulum.platform_rate, finite("theta_dot", pendulum.theta_dot)]


def moments_about_centre(body: Body) -> Array:
    """Returns the moments of inertia about the centre of mass [kg m^2], shape (3, 3). The moments
    of `body` are about the pivot."""
    offset = body.mass * body.com_distance**2
    moments = np.diag([body.inertia_x - offset, body.inertia_y - offset, body.inertia_z])
    moments[1, 2] = moments[2, 1] = body.inertia_yz
    return moments


def holding_inertia(pendulum: ConePendulum) -> float:
    """Returns the moment of inertia [kg m^2] with which a platform keeps its rate to the last bit
    under its load. It is a power of ten, from a bound on the body's moment of inertia about the
    platform's axis."""
    body = pendulum.body
    reach = abs(pendulum.pivot_y) + body.com_distance
    spread = float(np.trace(moments_about_centre(body)))
    load = body.mass * (pendulum.pivot_x**2 + reach**2) + spread
    return float(10.0 ** math.ceil(math.log10(PLATFORM_RATIO * load)))


def ideal(problem: ConePendulum) -> Idealisations:
    """Returns the idealisation: the platform turns at a prescribed rate."""
    rate = problem.platform_rate
    return Idealisations(velocities={"platform": lambda times: np.full(len(times), rate)})


def observe(problem: ConePendulum, qpos: Array, qvel: Array) -> Signals:
    """Returns the cone's angle and its rate."""
    return hinge_angle(qpos, qvel)


MODEL = ModelFile(
    fill, observe, ideal, largest=lambda problem: largest_pendulum_rates(problem.started)
)
