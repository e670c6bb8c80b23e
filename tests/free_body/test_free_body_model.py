"""The free body's MJCF, its scenes, and every engine that simulates it."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plumbob.analytic.numerics.quad import double
from plumbob.engines.adapters.mujoco.free_body import whole
from plumbob.models.registry import case_of, scene, systems

SYSTEM = systems()["free-body"]
MJCF = SYSTEM.mjcf
FLIP = case_of(scene("free-body/flip"))


def test_numbers_are_those_of_the_default_scene():
    model = mujoco.MjModel.from_xml_path(str(MJCF))
    body, start = model.body("body"), model.key("start")
    np.testing.assert_array_equal(body.inertia, FLIP.problem.inertia)
    np.testing.assert_array_equal(body.iquat, [1.0, 0.0, 0.0, 0.0])  # no axes are exchanged
    np.testing.assert_array_equal(start.qvel[3:], FLIP.problem.angular_velocity)
    np.testing.assert_array_equal(start.qpos, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    assert not model.opt.gravity.any()


def test_every_parameter_reaches_the_model():
    body = replace(
        FLIP.problem, inertia_x=3.0, inertia_y=4.0, inertia_z=5.0, angular_velocity=(1.0, -2.0, 0.5)
    )
    model = whole(MJCF, body).compile()
    np.testing.assert_array_equal(model.body("body").inertia, [3.0, 4.0, 5.0])
    np.testing.assert_array_equal(model.key("start").qvel[3:], [1.0, -2.0, 0.5])


@pytest.mark.parametrize("k", [3, 6, 9])
def test_scenes_are_as_far_off_the_separatrix_as_they_say(k):
    case = case_of(scene(f"free-body/separatrix-1e-{k}"))
    turning, body = case.problem.rotation.turning, case.problem
    # w_x over that of the separatrix, 3/4 of w_z for these moments, is 1 + 10^-k
    assert body.angular_velocity[0] / 3.0 - 1.0 == pytest.approx(10.0**-k, rel=2e-16 / 10.0**-k)
    square = float(double((turning.b / turning.a) ** 2))
    assert square == pytest.approx(1.6 * 10.0**-k, rel=0.5)
    assert body.half_period < case.scene.duration  # it turns over
