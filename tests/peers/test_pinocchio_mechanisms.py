"""Parts of mechanisms in Pinocchio: prescribed joints, ranges of forces, and loops."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
from plumbob.engines.registry import method as find_method
from plumbob.engines.stepper import State
from plumbob.engines.study.measurement import measure, relative_error
from plumbob.tests.peers.test_dart_mechanisms import case, default, scene_mechanism
from plumbob.tests.peers.test_mechanisms import LOOPS, STEP, found, pinocchio
from plumbob.tests.peers.test_smooth_peers import needed


@pytest.fixture(autouse=True)
def installed():
    """Pinocchio, without which these tests are skipped."""
    found("pinocchio")


@pytest.mark.parametrize(("near", "kept"), [(None, True), (1e-4, False)])
def test_a_prescribed_joint_keeps_its_course(near, kept, monkeypatch):
    """A platform whose rate is 2 + sin 3t: the body on it has the motion of a platform that a
    torque turns so, and the rate is as prescribed to the error of RK4 and of a difference of rates,
    which over 0.1 ms in place of 1 us is too coarse."""
    from plumbob.engines.adapters.pinocchio import builder

    if near is not None:
        monkeypatch.setattr(builder, "NEAR", near)
    parts = scene_mechanism("cone-pendulum/rotating-base")
    (platform, hinge) = parts.mechanism.joints
    moving = replace(platform, velocity=lambda times: 2.0 + np.sin(3.0 * times))
    mechanism = replace(parts.mechanism, joints=(moving, hinge))
    start = State(parts.start.qpos, np.array([2.0, 0.0]))
    made = pinocchio(mechanism, start)
    made.put(start, 0.5)
    made.advance(None, 200)
    # From 0.5 s on, with the rate that it was put with: 0.2 s of the course's acceleration.
    rate = 2.0 + np.sin(3.0 * 0.7) - np.sin(3.0 * 0.5)
    assert (abs(made.state().qvel[0] - rate) <= 1e-9) == kept


def test_the_range_of_forces_of_a_joint_holds_for_its_motors_together():
    """Two motors of 3 N m each on a joint that takes 4 N m, beside a damper that it does not
    count: a body of 1 kg m^2, which 2 rad/s of a damper of 0.5 N m s slow down."""
    xml = """<mujoco><worldbody><body><joint name="j" damping="0.5" actuatorfrcrange="-4 4"/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody>
      <actuator><motor joint="j"/><motor joint="j"/></actuator></mujoco>"""
    mechanism = compiled_mechanism(mujoco.MjModel.from_xml_string(xml))
    made = pinocchio(mechanism, None)
    made.put(State(np.zeros(1), np.array([2.0])))
    made.advance(np.full((1, 2), 3.0), 1)
    # RK4's step: v' = 4 - 0.5 v.
    exact = 8.0 - 6.0 * np.exp(-0.5 * STEP)
    assert made.state().qvel[0] == pytest.approx(exact, rel=1e-14)


@pytest.mark.parametrize("name", LOOPS)
def test_pinocchio_s_loops_have_the_order_of_rk4_whatever_closes_them(name, monkeypatch):
    """Halving a step divides the error by 16 or so, and closing what has opened at 20/s in place of
    50/s changes it by less than a half: the integrator makes the error, not the stabilisation."""
    needed("pinocchio/aba+rk4")
    from plumbob.engines.adapters.pinocchio import builder

    scene, how = case(default(name)), find_method("pinocchio/aba+rk4")
    errors = []
    for closing, step in ((50.0, 2e-3), (50.0, 1e-3), (20.0, 1e-3)):
        monkeypatch.setattr(builder, "CLOSING", closing)
        run = measure(scene, how, step)[0]
        errors.append(relative_error(run, scene.system.quantities(scene)))
    assert errors[1] < 1e-7
    assert 8.0 < errors[0] / errors[1] < 32.0
    assert 0.5 < errors[2] / errors[1] < 1.5
