"""The free body's MJCF, its scenes, and every engine that simulates it."""

from dataclasses import replace

import numpy as np

from plumbob.engines.adapters.mujoco.translation import filled
from plumbob.models.free_body.model import MODEL
from plumbob.models.registry import case_of, scene, systems

SYSTEM = systems()["free-body"]
MJCF = SYSTEM.mjcf
FLIP = case_of(scene("free-body/flip"))


def test_every_parameter_reaches_the_model():
    body = replace(
        FLIP.problem,
        inertia_x=3.0,
        inertia_y=4.0,
        inertia_z=5.0,
        angular_velocity=(1.0, -2.0, 0.5),
    )
    model = filled(MJCF, MODEL, body).compile()
    np.testing.assert_array_equal(model.body("body").inertia, [3.0, 4.0, 5.0])
    np.testing.assert_array_equal(model.key("start").qvel[3:], [1.0, -2.0, 0.5])
