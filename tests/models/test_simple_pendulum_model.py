"""The simple pendulum's MJCF: its literal numbers, its scene, and what the adapter builds from
it."""

import mujoco
import numpy as np
import pytest

from plumbob.analytic.systems.pendulums.rod_tension import BOB_MASS
from plumbob.analytic.systems.simple_pendulum import SimplePendulum
from plumbob.engines.adapters.mujoco.translation import filled
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of, systems
from plumbob.models.simple_pendulum.model import MODEL

MJCF = systems()["simple-pendulum"].mjcf


def problem(name="simple-pendulum", **changes):
    """The problem of a system's default scene, with parameters changed."""
    scene = find_scene(name, changes)
    found = system_of(scene).problem(scene.parameters)
    assert isinstance(found, SimplePendulum)
    return found


def test_every_parameter_reaches_the_model():
    given = {
        "length": 2.5,
        "gravity": 3.7,
        "damping_rate": 0.3,
        "forcing_amplitude": 1.5,
        "forcing_frequency": 2.0,
        "theta": 0.4,
        "theta_dot": -0.7,
    }
    moment = BOB_MASS * 2.5**2
    for name, spring in (("simple-pendulum", 0.0), ("linear-pendulum", BOB_MASS * 3.7 * 2.5)):
        model = filled(MJCF, MODEL, problem(name, **given)).compile()
        assert model.body("bob").ipos[2] == -2.5
        assert model.opt.gravity[2] == (0.0 if spring else -3.7)
        assert model.dof_damping[0] == pytest.approx(0.3 * moment, rel=1e-15)
        assert model.actuator("forcing").gear[0] == moment
        assert model.jnt_stiffness[0] == pytest.approx(spring, rel=1e-15)
        assert (model.key("start").qpos[0], model.key("start").qvel[0]) == (0.4, -0.7)
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
        data.ctrl[0] = 1.5 * np.sin(2.0 * 0.9)
        mujoco.mj_forward(model, data)
        wanted = float(problem(name, **given).rotor.acceleration(0.9, 0.4, -0.7))
        assert data.qacc[0] == pytest.approx(wanted, rel=1e-14)  # a dozen operations
