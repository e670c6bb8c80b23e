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
from plumbob.tests.peers.test_dart_mechanisms import (
    ALL_JOINTS,
    BALL,
    FLOOR,
    PAIR,
    STEP,
    SYSTEMS,
    default,
    model_and_mechanism,
    scene_mechanism,
)
from plumbob.tests.peers.test_smooth_peers import needed
from plumbob.tests.support.built_mechanisms import (
    assert_nothing_survives_put,
    stepped,
)
from plumbob.tests.support.cases import error_of_run

ITERATED, HARD = "pybullet/undamped+iterated", "pybullet/undamped+hard"
INERTIA = 0.02  # [kg m^2] of scenes with a capsule
# [s]: a step changes velocities by the accelerations that it begins with, times this
LONG = 1e-2
SHORT = 1e-6  # [s]
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
    proportion to the step, here of 1e-6 s, whose rounding is 1e-16/1e-6. A mass that is wrong by
    1e-5 is noticed, and so is a step ten times as long."""
    assert largest_difference(TURNED, SHORT) <= 1e-6
    assert largest_difference(TURNED, 10.0 * SHORT) > 1e-6

    def change(mechanism):
        heavier = (replace(body, mass=(1.0 + 1e-5) * body.mass) for body in mechanism.bodies)
        return replace(mechanism, bodies=tuple(heavier))

    assert largest_difference(TURNED, SHORT, change) > 1e-6


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


def largest_deviation_of_a_prescribed_velocity(**settings):
    """The largest difference [m/s] of a slider's velocity from the velocity that is prescribed for
    it, whose largest is 0.4 m/s, beside contacts with friction."""
    parts = scene_mechanism("capsule-line/ca1")
    made = stepper(parts.mechanism, **settings)
    made.put(parts.start)
    (slider,) = (x for x in parts.mechanism.joints if x.velocity is not None)
    deviations = []
    for k in range(1, 80):
        made.advance(None, 1)
        wanted = slider.velocity(np.array([k * STEP]))[0]
        deviations.append(abs(made.state().qvel[-1] - wanted))
    return max(deviations)


def test_a_prescribed_joint_has_its_velocity_at_every_grid_time():
    # 200 iterations of motors and contacts leave nothing, and rounding is 1e-16.
    assert largest_deviation_of_a_prescribed_velocity() <= 1e-14
    # Bullet's default ends the iterations at a residual of 1e-7.
    assert largest_deviation_of_a_prescribed_velocity(solverResidualThreshold=1e-7) > 1e-5


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


def test_friction_turns_away_from_the_slip_as_inertia_along_it_differs():
    """The error of friction off the axes is of the masses that resist two tangents: a moment of
    inertia that is a hundred times as large makes them equal, and the error is that of the step."""
    name = "capsule-line/heading-030"
    assert error_of_run(name, ITERATED, STEP) == pytest.approx(0.051, rel=0.02)
    assert error_of_run(name, ITERATED, STEP, changes={"inertia": 100.0 * INERTIA}) < 0.002


def test_a_pyramid_of_friction_is_wrong_whatever_the_inertia():
    name, pyramid = "capsule-line/heading-030", "pybullet/undamped+pyramid"
    for factor in (1.0, 100.0):
        assert error_of_run(
            name, pyramid, STEP, changes={"inertia": factor * INERTIA}
        ) == pytest.approx(0.28, abs=0.01)


IMPACT = "rod-impact/reverses"
# friction that ends the slip in the exact impact, too, as in PyBullet from 0.462 on
ENDS_SLIP = 0.8


def test_friction_does_not_turn_round_in_an_impact():
    """One solution for the impulses of a step ends the slip that the exact impact turns round: the
    error falls as friction comes near to a friction that ends the slip in the exact impact, too."""
    step = 1e-4
    errors = [
        error_of_run(IMPACT, HARD, step, changes={"friction": friction})
        for friction in (0.5, 0.6, ENDS_SLIP)
    ]
    assert errors[0] > 2.0 * errors[1] > 100.0 * errors[2]
    assert errors[2] < 3e-4  # the error of the step


@pytest.mark.parametrize("law", ["poisson", "energetic"])
def test_restitution_is_newton_s_whatever_the_law_of_the_scene(law):
    """If friction ends the slip, the law of restitution alone makes the error, which is in
    proportion to the restitution."""
    step, lasting = 1e-4, 0.345  # [s], before an end strikes again
    large, small = (
        error_of_run(
            IMPACT,
            HARD,
            step,
            lasting,
            {"law": law, "friction": ENDS_SLIP, "restitution": restitution},
        )
        for restitution in (0.5, 0.25)
    )
    # The step adds its error of 2e-4 to 4e-3.
    assert large / small == pytest.approx(2.0, rel=0.05)


def test_an_impact_without_a_collision_has_no_rebound():
    """Painleve's rod rests on the floor in PyBullet, and rises by a rebound in the exact motion:
    the error after a time in proportion to the restitution is as its square."""
    step = 1e-4
    part, whole = (
        error_of_run(
            "rod-impact/painleve",
            HARD,
            step,
            0.06 * restitution,
            {"restitution": restitution},
        )
        for restitution in (0.2, 0.4)
    )
    # Gravity turns the rod besides, in proportion to the time: by 1 % here.
    assert whole / part == pytest.approx(4.0, rel=0.03)


@pytest.mark.long(keep=0)
def test_contacts_have_a_static_penetration_of_the_slop():
    """Five cubes of 0.2 m stand 10 micrometres in each other and in the ground: 2.5e-4 of one."""
    errors = [
        error_of_run("stack/equal", ITERATED, STEP, contactSlop=slop) for slop in (4e-5, 1e-5)
    ]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.4)
    # A cube that is held slides until its contact has that.
    assert (
        error_of_run("incline/rest", HARD, STEP)
        < 1e-9
        < 1e-5
        < error_of_run("incline/rest", ITERATED, STEP)
    )


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
    assert error_of_run(name, HARD, step) < 4e-4
    assert error_of_run(name, HARD, step, **settings) > 1e-2


@pytest.mark.long(keep=0)
def test_more_iterations_carry_a_heavier_cube():
    """A cube of ten thousand times the mass stands on another one."""
    scene, step, lasting = "stack/heavy-top", 2e-3, 0.2  # [s]
    few, many = (
        error_of_run(scene, HARD, step, lasting, numSolverIterations=count)
        for count in (200, 5000)
    )
    assert few > 0.5 > 0.05 > many
