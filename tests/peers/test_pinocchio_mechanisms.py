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


def test_a_prescribed_joint_keeps_its_course():
    """A platform whose rate is 2 + sin 3t: the body on it has the motion of a platform that a
    torque turns so, and the rate is that to the error of RK4 and of a difference of rates."""
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
    assert made.state().qvel[0] == pytest.approx(rate, abs=1e-9)


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


@pytest.mark.parametrize("kind", ["weld", "connect"])
def test_a_loop_keeps_two_free_bodies_together(kind):
    """A pair that turns in free space: a weld keeps the relative pose, a ball joint the point."""
    bodies = "".join(
        f'<body name="{name}" pos="{pos}" quat="{quat}"><freejoint/>'
        '<inertial pos="0.1 0.1 0" mass="1" diaginertia="0.1 0.2 0.15"/></body>'
        for name, pos, quat in (("a", "0 0 1", "1 0.2 0.3 0"), ("b", "0.5 0 1", "1 0 0.3 0.4"))
    )
    anchor = 'anchor="0.2 0.1 0"' if kind == "connect" else ""
    loop = f'<equality><{kind} body1="a" body2="b" {anchor}/></equality>'
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{bodies}</worldbody>{loop}</mujoco>"
    )
    data = mujoco.MjData(model)
    mechanism = replace(compiled_mechanism(model), gravity=np.zeros(3))
    made = pinocchio(mechanism, None)
    # Both bodies turn about the first one's frame, so that neither loop opens.
    spin, apart = np.array([1.0, 2.0, 3.0]), np.array([0.5, 0.0, 0.0])
    turns = [
        data.xmat[i].reshape(3, 3).copy()
        for i in (1, 2)
        if not mujoco.mj_kinematics(model, data)
    ]
    rates = [np.zeros(3), turns[0].T @ spin, np.cross(spin, apart), turns[1].T @ spin]
    made.put(State(model.qpos0, np.concatenate(rates)))

    def gap():
        """The second body's point of the loop from the first one's, and its attitude in the first
        one's frame."""
        data.qpos[:] = made.state().qpos
        mujoco.mj_kinematics(model, data)
        frames = [data.xmat[i].reshape(3, 3) for i in (1, 2)]
        points = [data.xpos[i] + f @ p for i, f, p in zip((1, 2), frames, places, strict=True)]
        return points[1] - points[0], frames[0].T @ frames[1]

    places = mechanism.loops[0].places
    before = gap()
    made.advance(None, 500)
    opened, turned = gap()
    # RK4's error of half a second at steps of 1 ms.
    np.testing.assert_allclose(opened, 0.0, atol=1e-9)
    assert (np.abs(turned - before[1]).max() < 1e-9) == (kind == "weld")


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
