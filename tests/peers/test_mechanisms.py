"""Mechanisms in engines that build them: MuJoCo's mass matrix and forces, nothing that survives
`put`, and names of what an engine does not express. A row of ENGINES is an engine."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
from plumbob.engines.method import Unsupported
from plumbob.engines.registry import method as find_method
from plumbob.engines.stepper import State
from plumbob.engines.study.measurement import measure, relative_error
from plumbob.tests.peers.test_dart_mechanisms import (
    BALL,
    FLOOR,
    PAIR,
    case,
    default,
    model_and_mechanism,
    scene_mechanism,
    stepped,
)
from plumbob.tests.peers.test_smooth_peers import needed
from plumbob.tests.support.built_mechanisms import largest_difference_of_terms

STEP = 1e-3  # [s]
# Sums of tens of products in double precision, which cancel by a factor of a thousand at most.
CLOSE = 1e-12
TREES = (
    *("projectile", "simple-pendulum", "linear-pendulum", "cone-pendulum", "n-pendulum"),
    *("heavy-top", "servo", "free-body"),
)
LOOPS = ("four-bar", "slider-crank")


def pinocchio(mechanism, start, how="pinocchio/aba+rk4"):
    from plumbob.engines.adapters.pinocchio.stepper import PinocchioStepper

    return PinocchioStepper(mechanism, find_method(how).scheme.integrator, STEP)


def pinocchio_s_terms(made, mechanism, qpos, controls):
    """The mass matrix, bias, passive and actuator forces, whose rates are MuJoCo's."""
    import pinocchio as pin

    from plumbob.engines.adapters.pinocchio.builder import Dynamics

    dynamics, now = made.dynamics, made.state()
    passive = Dynamics(replace(dynamics.mechanism, actuators=()))
    q = dynamics.configured(qpos)
    upper = np.triu(pin.crba(dynamics.model, dynamics.data, q))
    bias = pin.nonLinearEffects(dynamics.model, dynamics.data, q, now.qvel)
    carried = pin.computeGeneralizedGravity(dynamics.carried, dynamics.weights, q)
    forces = dynamics.forces(q, qpos, now.qvel, controls)
    without = passive.forces(q, qpos, now.qvel, ())
    return (
        upper + np.triu(upper, 1).T,
        bias - carried,
        without - carried,
        forces - without,
    )


@dataclass(frozen=True)
class Subject:
    """An engine in these tests."""

    method: str
    stepper: Callable
    terms: Callable
    systems: tuple[str, ...]


ENGINES = {
    "pinocchio": Subject("pinocchio/aba+rk4", pinocchio, pinocchio_s_terms, (*TREES, *LOOPS)),
}
PAIRS = [(engine, name) for engine, own in ENGINES.items() for name in own.systems]


@pytest.fixture(params=ENGINES)
def subject(request):
    return found(request.param)


def found(engine):
    """An engine, without which a test is skipped."""
    needed(ENGINES[engine].method)
    return ENGINES[engine]


def largest_difference(subject, name, change=lambda mechanism: mechanism):
    model, mechanism, start = model_and_mechanism(name)
    made = subject.stepper(change(mechanism), start)
    return largest_difference_of_terms(model, mechanism, made, subject.terms)


@pytest.mark.parametrize(
    ("engine", "name"), [*PAIRS, *((engine, "all joints") for engine in ENGINES)]
)
def test_a_mechanism_has_mujoco_s_mass_matrix_and_forces(engine, name):
    assert largest_difference(found(engine), name) <= CLOSE


@pytest.mark.parametrize(
    ("part", "field"),
    [
        ("bodies", "mass"),
        ("bodies", "place"),
        ("joints", "stiffness"),
        ("joints", "armature"),
        ("actuators", "gain"),
    ],
)
def test_a_number_that_is_wrong_by_1e_10_is_noticed(subject, part, field):
    def change(mechanism):
        parts = getattr(mechanism, part)
        changed = [replace(x, **{field: (1.0 + 1e-10) * getattr(x, field)}) for x in parts]
        return replace(mechanism, **{part: tuple(changed)})

    assert largest_difference(subject, "all joints", change) > CLOSE


@pytest.mark.parametrize(("engine", "name"), PAIRS)
def test_put_and_step_equals_fresh_and_step_to_the_bit(engine, name):
    parts = scene_mechanism(default(name))
    make = found(engine).stepper
    used = make(parts.mechanism, parts.start)
    used.put(parts.start)
    between = stepped(used, parts, 100)
    stepped(used, parts, 50, 100)
    for state, time in ((between, 100 * STEP), (parts.start, 0.0)):
        fresh = make(parts.mechanism, parts.start)
        for made in (used, fresh):
            made.put(state, time)
        after, expected = (
            stepped(made, parts, 20, round(time / STEP)) for made in (used, fresh)
        )
        np.testing.assert_array_equal(after.qpos, expected.qpos)
        np.testing.assert_array_equal(after.qvel, expected.qvel)


ONE = '<body><joint name="d" {} /><geom size="1"/></body>'
FEATURES = {
    "pinocchio": {
        "drag of the medium": (ONE.format(""), '<option viscosity="1"/>'),
        "contact of p and g": (FLOOR + BALL, PAIR.format("")),
        "limit or dry friction of joint d": (ONE.format('frictionloss="1"'), ""),
        "spring of joint d, which is a ball joint": (
            ONE.format('type="ball" stiffness="1"'),
            "",
        ),
    }
}
REFUSED = [(engine, name) for engine, own in FEATURES.items() for name in own]


@pytest.mark.parametrize(("engine", "feature"), REFUSED)
def test_a_feature_that_is_not_expressed_is_refused_by_its_name(engine, feature):
    bodies, rest = (part.replace("{}", "") for part in FEATURES[engine][feature])
    xml = f"<mujoco><worldbody>{bodies}</worldbody>{rest}</mujoco>"
    mechanism = compiled_mechanism(mujoco.MjModel.from_xml_string(xml))
    with pytest.raises(Unsupported, match=feature):
        found(engine).stepper(mechanism, None)


def test_a_prescribed_joint_keeps_its_course(subject):
    """A platform whose rate is 2 + sin 3t: the body on it has the motion of a platform that a
    torque turns so, and the rate is that to the error of RK4 and of a difference of rates."""
    parts = scene_mechanism("cone-pendulum/rotating-base")
    (platform, hinge) = parts.mechanism.joints
    moving = replace(platform, velocity=lambda times: 2.0 + np.sin(3.0 * times))
    mechanism = replace(parts.mechanism, joints=(moving, hinge))
    start = State(parts.start.qpos, np.array([2.0, 0.0]))
    made = subject.stepper(mechanism, start)
    made.put(start, 0.5)
    made.advance(None, 200)
    # From 0.5 s on, with the rate that it was put with: 0.2 s of the course's acceleration.
    rate = 2.0 + np.sin(3.0 * 0.7) - np.sin(3.0 * 0.5)
    assert made.state().qvel[0] == pytest.approx(rate, abs=1e-9)


def test_the_range_of_forces_of_a_joint_holds_for_its_motors_together(subject):
    """Two motors of 3 N m each on a joint that takes 4 N m, beside a damper that it does not
    count: a body of 1 kg m^2, which 2 rad/s of a damper of 0.5 N m s slow down."""
    xml = """<mujoco><worldbody><body><joint name="j" damping="0.5" actuatorfrcrange="-4 4"/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody>
      <actuator><motor joint="j"/><motor joint="j"/></actuator></mujoco>"""
    mechanism = compiled_mechanism(mujoco.MjModel.from_xml_string(xml))
    made = subject.stepper(mechanism, None)
    made.put(State(np.zeros(1), np.array([2.0])))
    made.advance(np.full((1, 2), 3.0), 1)
    # RK4's step: v' = 4 - 0.5 v.
    exact = 8.0 - 6.0 * np.exp(-0.5 * STEP)
    assert made.state().qvel[0] == pytest.approx(exact, rel=1e-14)


@pytest.mark.parametrize("kind", ["weld", "connect"])
def test_a_loop_keeps_two_free_bodies_together(subject, kind):
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
    made = subject.stepper(mechanism, None)
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
