"""Mechanisms in PyBullet: MuJoCo's accelerations, nothing that survives `put`, names of what is not
expressed, and the settings that make errors of contacts."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
from plumbob.engines.adapters.mujoco.options import collected
from plumbob.engines.method import Unsupported
from plumbob.engines.registry import method
from plumbob.engines.stepper import State
from plumbob.engines.study.measurement import measure, relative_error
from plumbob.tests.peers.test_dart_mechanisms import (
    ALL_JOINTS,
    BALL,
    FLOOR,
    PAIR,
    STEP,
    SYSTEMS,
    case,
    default,
    model_and_mechanism,
    scene_mechanism,
)
from plumbob.tests.peers.test_smooth_peers import needed
from plumbob.tests.support.built_mechanisms import (
    assert_nothing_survives_put,
    stepped,
)

ITERATED, HARD = "pybullet/undamped+iterated", "pybullet/undamped+hard"
LONG = (
    1e-2  # [s]: a step changes velocities by the accelerations that it begins with, times this
)
# Sums of tens of products in double precision, which cancel by a factor of a thousand at most.
CLOSE = 1e-12
TURNED = "all joints"  # a mechanism that has a free body whose frame is not at its centre


@pytest.fixture(autouse=True)
def pybullet():
    """PyBullet, without which these tests are skipped."""
    needed(ITERATED)


def stepper(mechanism, step=STEP, name=ITERATED, **settings):
    from plumbob.engines.adapters.pybullet.stepper import BulletStepper

    return BulletStepper(mechanism, {**method(name).settings, **settings}, step)


def smooth(mechanism):
    """A mechanism without what acts by impulses."""
    joints = (replace(joint, velocity=None) for joint in mechanism.joints)
    return replace(mechanism, joints=tuple(joints), loops=(), touching=(), shapes=())


def parts_of(name):
    if name != TURNED:
        return model_and_mechanism(name)[:2]
    text = ALL_JOINTS.replace(' armature="0.3"', "")
    model = mujoco.MjModel.from_xml_string(text)
    return model, compiled_mechanism(model)


def largest_difference(name, step, change=lambda mechanism: mechanism):
    """The largest difference of accelerations from MuJoCo's in random states, relative to the
    largest acceleration; states that are put come back."""
    model, mechanism = parts_of(name)
    made = stepper(smooth(change(mechanism)), step)
    driven = {a.control for a in mechanism.actuators}
    data = mujoco.MjData(model)
    rng = np.random.default_rng(0)
    worst = 0.0
    for _ in range(3):
        data.qpos[:] = model.qpos0
        mujoco.mj_integratePos(model, data.qpos, rng.normal(size=model.nv), 1.0)
        data.qvel[:] = rng.normal(size=model.nv)
        data.ctrl[:] = 2.0 * rng.normal(size=model.nu)
        data.ctrl[[i for i in range(model.nu) if i not in driven]] = 0.0
        with collected():
            mujoco.mj_forward(model, data)
        made.put(State(data.qpos.copy(), data.qvel.copy()))
        state = made.state()
        np.testing.assert_allclose(state.qpos, data.qpos, atol=1e-14)
        np.testing.assert_allclose(state.qvel, data.qvel, atol=1e-14)
        made.advance(data.ctrl[None].copy() if model.nu else None, 1)
        found = (made.state().qvel - data.qvel) / step
        wanted = data.qacc_smooth
        worst = max(worst, np.abs(found - wanted).max() / np.abs(wanted).max())
    return worst


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_mechanism_in_pybullet_has_mujoco_s_accelerations(name):
    assert largest_difference(name, LONG) <= CLOSE


def test_all_kinds_of_joints_have_mujoco_s_accelerations():
    """The velocity of a free body's frame is of its attitude after the step: that adds an error in
    proportion to the step, here of 1e-6 s, whose rounding is 1e-16/1e-6."""
    assert largest_difference(TURNED, 1e-6) <= 1e-6


@pytest.mark.parametrize(
    ("name", "part", "field"),
    [
        ("n-pendulum", "bodies", "mass"),
        ("n-pendulum", "bodies", "place"),
        ("linear-pendulum", "joints", "stiffness"),
        ("servo", "joints", "armature"),
        ("servo", "actuators", "gain"),
    ],
)
def test_a_number_that_is_wrong_by_1e_9_is_noticed(name, part, field):
    def change(mechanism):
        first, *others = getattr(mechanism, part)
        factor = 1.0 + 1e-9
        last = others[-1] if others else first
        changed = replace(last, **{field: factor * getattr(last, field)})
        return replace(mechanism, **{part: (*[first, *others][:-1], changed)})

    assert largest_difference(name, LONG, change) > CLOSE


@pytest.mark.long(keep=12)
@pytest.mark.parametrize("name", SYSTEMS)
def test_put_and_step_equals_fresh_and_step_to_the_bit(name):
    parts = scene_mechanism(default(name))
    assert_nothing_survives_put(lambda: stepper(parts.mechanism), parts)


def test_a_world_keeps_its_settings_beside_a_world_with_others():
    """Bullet has one distance of contact for all worlds of a process."""
    parts = scene_mechanism("bouncing-ball/half")
    found = []
    for others in ((), (HARD,)):
        made = stepper(parts.mechanism)
        made.put(parts.start)
        for name in others:
            other = stepper(parts.mechanism, name=name)
            other.put(parts.start)
            stepped(other, parts, 10)
        found.append(stepped(made, parts, 1000).qpos)
    np.testing.assert_array_equal(*found)


ONE = '<body><joint name="d" {}/><geom size="1"/></body>'
FEATURES = {
    "partly carried weight of body b": (
        '<body name="b" gravcomp="0.5"><joint/><geom size="1"/></body>',
        "",
    ),
    "drag of the medium": (ONE.format(""), '<option viscosity="1"/>'),
    "torsional or rolling friction of p and g": (FLOOR + BALL, PAIR.format('condim="4"')),
    "friction of p and g, different along two directions": (
        FLOOR + BALL,
        PAIR.format('friction="1 0.5"'),
    ),
    "ellipsoid g, which is no flat disc": (
        FLOOR + BALL.replace('size="0.1"', 'type="ellipsoid" size="0.1 0.1 0.2"'),
        PAIR,
    ),
    "spring, limit or dry friction of joint d, which is a ball joint": (
        ONE.format('type="ball" stiffness="1"'),
        "",
    ),
    "damping of joint d, which is a free joint": (ONE.format('type="free" damping="1"'), ""),
    "armature of joint d, which is no hinge or is turned by other joints": (
        '<body><joint/><geom size="1"/>' + ONE.format('armature="1"') + "</body>",
        "",
    ),
}


@pytest.mark.parametrize("feature", FEATURES)
def test_a_feature_that_is_not_expressed_is_refused_by_its_name(feature):
    bodies, rest = (part.replace("{}", "") for part in FEATURES[feature])
    xml = f"<mujoco><worldbody>{bodies}</worldbody>{rest}</mujoco>"
    with pytest.raises(Unsupported, match=feature):
        stepper(compiled_mechanism(mujoco.MjModel.from_xml_string(xml)))


def made_of(xml, qpos, qvel):
    """A mechanism of MJCF in a state."""
    mechanism = compiled_mechanism(mujoco.MjModel.from_xml_string(f"<mujoco>{xml}</mujoco>"))
    made = stepper(mechanism)
    made.put(State(np.array(qpos), np.array(qvel)))
    return made


ROTOR = """<option gravity="0 0 0"/><worldbody><body><joint axis="0 0 1" {}/>
<inertial pos="0 0 0" mass="1" diaginertia="1 1 2"/></body></worldbody>
<compiler angle="radian"/>"""


def test_a_prescribed_joint_has_its_velocity_at_every_grid_time():
    parts = scene_mechanism("capsule-line/ca1")
    made = stepper(parts.mechanism)
    made.put(parts.start)
    (slider,) = (x for x in parts.mechanism.joints if x.velocity is not None)
    for k in range(1, 80):
        made.advance(None, 1)
        wanted = slider.velocity(np.array([k * STEP]))[0]
        # the largest is 0.4 m/s; 200 iterations of motors and contacts leave this
        assert made.state().qvel[-1] == pytest.approx(wanted, abs=1e-9)


def test_dry_friction_of_a_joint_is_exact():
    """A rotor of 2 kg m^2 that 3 N m slow from 1 rad/s stops after 2/3 s and stays."""
    made = made_of(ROTOR.format('frictionloss="3"'), [0.0], [1.0])
    made.advance(None, 500)
    assert made.state().qvel[0] == pytest.approx(1.0 - 0.5 * 3.0 / 2.0, rel=1e-12)
    made.advance(None, 500)
    assert made.state().qvel[0] == pytest.approx(0.0, abs=1e-12)


def test_a_limit_stops_a_joint():
    made = made_of(ROTOR.format('limited="true" range="-1 0.3" ref="0.1"'), [0.2], [2.0])
    made.advance(None, 200)
    # A limit yields by what a body moves in a step or two.
    assert made.state().qpos[0] == pytest.approx(0.3, abs=4e-3)


def test_bodies_turn_faster_than_bullet_s_default_limit_of_100_rad_a_second():
    made = made_of(ROTOR.format(""), [0.0], [500.0])
    made.advance(None, 1)
    assert made.state().qvel[0] == 500.0
    slow = stepper(made.mechanism, maxJointVelocity=100.0)
    slow.put(State(np.zeros(1), np.array([500.0])))
    slow.advance(None, 1)
    assert slow.state().qvel[0] == 100.0


def test_a_welded_pair_keeps_its_relative_pose():
    bodies = "".join(
        f'<body name="{name}" pos="{pos}" quat="{quat}"><freejoint/>'
        '<inertial pos="0.1 0.1 0" mass="1" diaginertia="0.1 0.2 0.15"/></body>'
        for name, pos, quat in (("a", "0 0 1", "1 0.2 0.3 0"), ("b", "0.5 0 1", "1 0 0.3 0.4"))
    )
    loop = '<equality><weld body1="a" body2="b"/></equality>'
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{bodies}</worldbody>{loop}</mujoco>"
    )
    data = mujoco.MjData(model)
    made = stepper(compiled_mechanism(model))
    made.put(State(model.qpos0, np.array([0.0, 0, 0, 1, 2, 3, 0, 0, 0, 0, 0, 0])))

    def relative():
        data.qpos[:] = made.state().qpos
        mujoco.mj_kinematics(model, data)
        frame = data.xmat[1].reshape(3, 3)
        return frame.T @ (data.xpos[2] - data.xpos[1]), frame.T @ data.xmat[2].reshape(3, 3)

    before = relative()
    made.advance(None, 500)
    turned = made.state().qpos[3:7]
    assert abs(turned @ model.qpos0[3:7]) / np.linalg.norm(model.qpos0[3:7]) < 0.99
    for now, then in zip(relative(), before, strict=True):
        # A fifth of what is open is closed a step: 5 step^2 times rates^2 are.
        np.testing.assert_allclose(now, then, atol=1e-4)


@pytest.mark.parametrize("kind", ["weld", "connect"])
def test_a_loop_holds_a_body_to_the_world_beside_bodies_that_fall(kind):
    body = """<body name="{0}" pos="0 0 1"><freejoint/>
    <inertial pos="0.1 0 0.2" mass="1" diaginertia="0.1 0.2 0.15"/></body>"""
    anchor = 'anchor="0.1 0 0.2"' if kind == "connect" else ""
    made = made_of(
        f"<worldbody>{body.format('held')}{body.format('free')}</worldbody>"
        f'<equality><{kind} body1="held" {anchor}/></equality>',
        [0.0, 0, 1, 1, 0, 0, 0] * 2,
        np.zeros(12),
    )
    made.advance(None, 200)
    held, fallen = made.state().qpos[[2, 9]]
    assert held == pytest.approx(1.0, abs=1e-4)  # within what is open and closed again
    assert fallen == pytest.approx(1.0 - 9.81 * 0.2**2 / 2, abs=1e-2)  # half a step's, too


def error(name, how, step=STEP, changes=(), **settings):
    """The relative error of a scene with some parameters times a factor."""
    run = method(how)
    run = replace(run, settings={**run.settings, **settings}, systems=(), kinds=())
    about = case(name)
    if changes:
        parameters = dict(about.scene.parameters)
        changed = {part: factor * parameters[part] for part, factor in changes}
        system = about.system
        problem = system.problem(system.change(parameters, changed))
        about = replace(about, problem=problem)
    return relative_error(measure(about, run, step)[0], about.system.quantities(about))


def test_friction_turns_away_from_the_slip_as_inertia_along_it_differs():
    """The error of friction off the axes is of the masses that resist two tangents: a moment of
    inertia that is a hundred times as large makes them equal, and the error is that of the step."""
    name = "capsule-line/heading-030"
    assert error(name, ITERATED) == pytest.approx(0.051, rel=0.02)
    assert error(name, ITERATED, changes=(("inertia", 100.0),)) < 0.002


def test_a_pyramid_of_friction_is_wrong_whatever_the_inertia():
    name, pyramid = "capsule-line/heading-030", "pybullet/undamped+pyramid"
    for factor in (1.0, 100.0):
        assert error(name, pyramid, changes=(("inertia", factor),)) == pytest.approx(
            0.28, abs=0.01
        )


@pytest.mark.long(keep=0)
def test_contacts_have_a_static_penetration_of_the_slop():
    """Five cubes of 0.2 m stand 10 micrometres in each other and in the ground: 2.5e-4 of one."""
    errors = [error("stack/equal", ITERATED, contactSlop=slop) for slop in (4e-5, 1e-5)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.4)
    # A cube that is held slides until its contact has that.
    assert error("incline/rest", HARD) < 1e-9 < 1e-5 < error("incline/rest", ITERATED)


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("bouncing-ball/half", {"contactERP": 0.08}),
        ("bouncing-ball/half", {"contactBreakingThreshold": 0.02}),
        ("rod-impact/sticks", {"contactERP": 0.08}),
    ],
)
def test_restitution_is_lost_to_contacts_before_shapes_touch_and_to_pushing_out(name, settings):
    """By default a contact acts before shapes touch, against a speed that it has lessened already,
    and a depth is pushed out by a velocity, which a rebound keeps."""
    step = 1e-4
    assert error(name, HARD, step) < 4e-4
    assert error(name, HARD, step, **settings) > 1e-2
