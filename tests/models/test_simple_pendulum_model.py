"""The simple pendulum's MJCF: its literal numbers, its scene, and what the adapter builds from
it."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from plumbob.analytic.errors.smooth_motion.pendulum_errors import simple_pendulum_errors
from plumbob.analytic.schemes import RK4, Scheme
from plumbob.analytic.systems.pendulums.rod_tension import MASS
from plumbob.analytic.systems.simple_pendulum import SimplePendulum
from plumbob.engines.adapters.hinged_body import POINT
from plumbob.engines.adapters.mujoco.simple_pendulum import whole
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of, systems

MJCF = systems()["simple-pendulum"].mjcf
FOLDER = MJCF.parent


def problem(name="simple-pendulum", **changes):
    """The problem of a system's default scene, with parameters changed."""
    scene = find_scene(name, changes)
    found = system_of(scene).problem(scene.parameters)
    assert isinstance(found, SimplePendulum)
    return found


def test_numbers_are_those_of_the_default_scene():
    model, given = mujoco.MjModel.from_xml_path(str(MJCF)), problem()
    bob, start = model.body("bob"), model.key("start")
    assert bob.mass[0] == MASS
    np.testing.assert_array_equal(bob.ipos, [0.0, 0.0, -given.length])
    np.testing.assert_array_equal(bob.inertia, POINT)
    np.testing.assert_array_equal(model.opt.gravity, [0.0, 0.0, -given.gravity])
    assert (start.qpos[0], start.qvel[0]) == (given.theta, given.theta_dot)
    assert model.dof_damping[0] == given.damping_rate
    assert model.actuator("forcing").gear[0] == MASS * given.length**2


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
    moment = MASS * 2.5**2
    for name, spring in (("simple-pendulum", 0.0), ("linear-pendulum", MASS * 3.7 * 2.5)):
        model = whole(MJCF, problem(name, **given)).compile()
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


@pytest.mark.parametrize("file", ["simple_pendulum.xml", "scene.xml"])
def test_loaded_on_its_own_it_swings_as_it_should(file):
    # 5000 steps of RK4 at 1e-3 s, with the error that theory predicts, 9e-12 rad, to round-off
    model = mujoco.MjModel.from_xml_path(str(FOLDER / file))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    mujoco.mj_step(model, data, nstep=5000)
    given = problem()
    times = np.array([5000 * model.opt.timestep])
    exact = given.motion.observe(times)
    predicted = simple_pendulum_errors(given).series(Scheme(RK4), times)
    wanted = exact["theta"][0] + sum(e["theta"][0] * 1e-3**p for p, e in predicted.items())
    assert data.qpos[0] == pytest.approx(wanted, abs=1e-12)
    mujoco.mj_forward(model, data)
    assert data.sensordata[2] == pytest.approx(exact["tension"][0], abs=2e-10)
    assert data.xipos[1][0] == pytest.approx(np.sin(wanted), abs=2e-12)
    assert not any(warning.number for warning in data.warning)
