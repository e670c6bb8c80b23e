"""The cone pendulum's MJCF: its literal numbers, its scene, and what the adapter builds from it."""

import math

import mujoco
import numpy as np

from plumbob.models.cone_pendulum.model import holding_inertia
from plumbob.tests.support.cone_scene import DEFAULT, MJCF

DENSITY = 8000.0
HEIGHT = 0.3
HALF_ANGLE = math.radians(15.0)


def expected():
    """The numbers of the file, from Sudakov 2015, eq. 1, and the parallel axis theorem."""
    tan2 = math.tan(HALF_ANGLE) ** 2
    mass = math.pi / 3 * DENSITY * HEIGHT**3 * tan2
    return {
        "mass": mass,
        "com": -0.75 * HEIGHT,
        "inertia_x": 3 / 80 * mass * HEIGHT**2 * (1 + 4 * tan2),
        "inertia_y": 3 / 80 * mass * HEIGHT**2 * (1 + 4 * tan2),
        "inertia_z": 3 / 10 * mass * HEIGHT**2 * tan2,
        "inertia_x about the pivot": 3 / 20 * mass * HEIGHT**2 * (4 + tan2),
        "pivot_y": 0.09,
        "gravity": -9.8,
        "platform_rate": 26.0,
        "theta_dot": 37.0,
    }


def found(model):
    """The same numbers as `model` has them."""
    cone = model.body("cone")
    start = model.key("start")
    return {
        "mass": cone.mass[0],
        "com": cone.ipos[2],
        "inertia_x": cone.inertia[0],
        "inertia_y": cone.inertia[1],
        "inertia_z": cone.inertia[2],
        "inertia_x about the pivot": cone.inertia[0] + cone.mass[0] * cone.ipos[2] ** 2,
        "pivot_y": cone.pos[1],
        "gravity": model.opt.gravity[2],
        "platform_rate": start.qvel[0],
        "theta_dot": start.qvel[1],
    }


def wrong(model):
    """Numbers with relative differences above 1e-12: they are written with 16 digits."""
    numbers = found(model)
    return {
        name for name, x in expected().items() if not abs(numbers[name] - x) <= 1e-12 * abs(x)
    }


def test_numbers_are_those_of_the_formulas():
    model = mujoco.MjModel.from_xml_path(str(MJCF))
    assert not wrong(model)
    cone = model.body("cone")
    np.testing.assert_array_equal(cone.iquat, [1, 0, 0, 0])
    np.testing.assert_array_equal([cone.pos[0], cone.pos[2], *cone.ipos[:2]], 0.0)
    np.testing.assert_array_equal(model.opt.gravity[:2], 0.0)
    np.testing.assert_array_equal(model.joint("theta").axis, [1, 0, 0])
    np.testing.assert_array_equal(model.joint("platform").axis, [0, 0, 1])
    np.testing.assert_array_equal(model.key("start").qpos, 0.0)
    assert model.joint("platform").armature[0] >= holding_inertia(DEFAULT)
