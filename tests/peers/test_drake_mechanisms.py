"""Mechanisms in Drake: MuJoCo's mass matrix and forces, nothing that survives `put`, and names of
what Drake does not express."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.linalg import block_diag

from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
from plumbob.engines.method import Unsupported
from plumbob.engines.registry import method
from plumbob.engines.stepper import State
from plumbob.models.registry import built_in_systems
from plumbob.tests.peers.test_dart_mechanisms import (
    BALL,
    FLOOR,
    PAIR,
    default,
    model_and_mechanism,
    scene_mechanism,
)
from plumbob.tests.peers.test_smooth_peers import needed
from plumbob.tests.support.built_mechanisms import (
    assert_nothing_survives_put,
    largest_difference_of_terms,
    stepped,
)

pytestmark = pytest.mark.filterwarnings("ignore:The TAMSI solver")


@pytest.fixture(autouse=True)
def drake():
    """Drake, without which these tests are skipped."""
    needed("drake/default")


# Sums of tens of products in double precision, which cancel by a factor of a thousand at most.
CLOSE = 1e-12
STEP = 1e-3  # [s]
BOUNCES = ("bouncing-ball", "rod-impact")  # have restitution by default
ALIKE = ("capsule-hold", "capsule-line", "capsule-plan", "capsule-train")  # as coast or turn
SYSTEMS = sorted(name for name in built_in_systems() if name not in BOUNCES + ALIKE)


def stepper(mechanism, settings=None):
    from plumbob.engines.adapters.drake.stepper import DrakeStepper

    return DrakeStepper(mechanism, {**(settings or {}), "time_step": STEP}, STEP)


def drakes_rates(made, mechanism, qpos):
    """The matrix by which Drake's rates follow from MuJoCo's."""
    order, turns, first = [], [], 0
    for joint, of_drake in zip(mechanism.joints, made.built.joints, strict=True):
        begin, count = of_drake.velocity_start(), of_drake.num_velocities()
        order += range(begin, begin + count)
        turn = np.eye(count)
        places = {"ball": 4, "free": 7}.get(joint.kind, 1)
        if joint.kind in ("ball", "free"):
            flat = np.zeros(9)
            mujoco.mju_quat2Mat(flat, qpos[first + places - 4 : first + places])
            turn = flat.reshape(3, 3)
        if joint.kind == "free":
            turn = np.block([[np.zeros((3, 3)), turn], [np.eye(3), np.zeros((3, 3))]])
        turns.append(turn)
        first += places
    rates = np.zeros((len(order), len(order)))
    rates[order] = block_diag(*turns)
    return rates


def terms(made, mechanism, qpos, controls):
    """Drake's mass matrix, bias, passive and actuator forces, along MuJoCo's degrees of freedom."""
    from pydrake.multibody.tree import MultibodyForces

    plant = made.built.plant
    within = plant.GetMyContextFromRoot(made.simulator.get_context())
    gravity = plant.CalcGravityGeneralizedForces(within)
    elements = MultibodyForces(plant)
    plant.CalcForceElementsContribution(within, elements)
    passive = plant.CalcGeneralizedForces(within, elements) - gravity
    actuators = np.zeros(plant.num_velocities())
    if made.built.motors.source is not None:
        made.drive(controls[None], 1)
        forces = plant.get_actuation_input_port().Eval(within)
        actuators = plant.MakeActuationMatrix() @ forces
    parts = (plant.CalcBiasTerm(within) - gravity, passive, actuators)
    turn = drakes_rates(made, mechanism, qpos)
    return turn.T @ plant.CalcMassMatrix(within) @ turn, *(turn.T @ part for part in parts)


def without_rotors(mechanism):
    """The mechanism with its prescribed joints free: their rotors hide the inertia they move."""
    joints = tuple(replace(joint, velocity=None) for joint in mechanism.joints)
    return replace(mechanism, joints=joints)


def largest_difference(name, change=lambda mechanism: mechanism):
    model, mechanism, _ = model_and_mechanism(name)
    mechanism = without_rotors(mechanism)
    made = stepper(change(mechanism))
    return largest_difference_of_terms(model, mechanism, made, terms)


@pytest.mark.parametrize("name", [*SYSTEMS, "all joints"])
def test_a_mechanism_in_drake_has_mujoco_s_mass_matrix_and_forces(name):
    assert largest_difference(name) <= CLOSE


@pytest.mark.parametrize(
    ("part", "field", "factor"),
    [
        ("bodies", "mass", 1.0 + 1e-10),
        ("bodies", "place", 1.0 + 1e-10),
        ("joints", "stiffness", 1.0 + 1e-10),
        ("joints", "armature", 1.0 + 1e-10),
        ("actuators", "gain", 1.0 + 1e-10),
    ],
)
def test_a_number_that_is_wrong_by_1e_10_is_noticed(part, field, factor):
    def change(mechanism):
        parts = getattr(mechanism, part)
        changed = [replace(x, **{field: factor * getattr(x, field)}) for x in parts]
        return replace(mechanism, **{part: tuple(changed)})

    assert largest_difference("all joints", change) > CLOSE


CASES = [(default(name), "drake/default") for name in SYSTEMS]
CASES.append(("capsule-line/heading-030", "drake/tamsi+stiction"))


@pytest.mark.parametrize(("name", "how"), CASES)
def test_put_and_step_equals_fresh_and_step_to_the_bit(name, how):
    parts = scene_mechanism(name)
    assert_nothing_survives_put(lambda: stepper(parts.mechanism, method(how).settings), parts)


def test_steps_taken_one_by_one_are_those_taken_at_once():
    parts = scene_mechanism("capsule-line/heading-030")
    ends = []
    for pieces in (1, 60):
        made = stepper(parts.mechanism)
        made.put(parts.start)
        for first in range(0, 60, 60 // pieces):
            stepped(made, parts, 60 // pieces, first)
        ends.append(made.state())
    # Velocities are differences of a course at times of which the last bit is rounded.
    np.testing.assert_allclose(ends[0].qpos, ends[1].qpos, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(ends[0].qvel, ends[1].qvel, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("name", ["capsule-turn/light-slider", "capsule-line/heavy-slider"])
def test_a_prescribed_joint_keeps_its_course(name):
    parts = scene_mechanism(name)
    made = stepper(parts.mechanism)
    made.put(parts.start)
    first = len(made.state().qvel) - sum(x.velocity is not None for x in parts.mechanism.joints)
    for begin, step in ((0, 17), (17, 40)):
        rates = stepped(made, parts, step - begin, begin).qvel[first:]
        held = [x.velocity for x in parts.mechanism.joints if x.velocity is not None]
        exact = [velocity(np.array([step * STEP]))[0] for velocity in held]
        # The rotor is 1e8 times as heavy as all bodies, and a rate that of the strokes.
        np.testing.assert_allclose(rates, exact, atol=1e-7)


ROLLS = PAIR.format('condim="6"')
FEATURES = {
    "partly carried weight of body b": (
        '<body name="b" gravcomp="0.5"><joint/><geom size="1"/></body>',
        "",
    ),
    "drag of the medium": ('<body><joint/><geom size="1"/></body>', '<option viscosity="1"/>'),
    "torsional or rolling friction of p and g": (FLOOR + BALL, ROLLS),
    "friction of p and g, different along two directions": (
        FLOOR + BALL,
        PAIR.format('friction="1 0.5"'),
    ),
    "spring, limit or armature of joint s, which is a ball joint": (
        '<body><joint name="s" type="ball" stiffness="1"/><geom size="1"/></body>',
        "",
    ),
    "dry friction of joint d": (
        '<body><joint name="d" frictionloss="1"/><geom size="1"/></body>',
        "",
    ),
}


@pytest.mark.parametrize("feature", FEATURES)
def test_a_feature_that_is_not_expressed_is_refused_by_its_name(feature):
    bodies, rest = (part.replace("{}", "") for part in FEATURES[feature])
    xml = f"<mujoco><worldbody>{bodies}</worldbody>{rest}</mujoco>"
    with pytest.raises(Unsupported, match=feature):
        stepper(compiled_mechanism(mujoco.MjModel.from_xml_string(xml)))


def test_restitution_and_loops_that_a_solver_has_not_are_refused_by_name():
    with pytest.raises(Unsupported, match="restitution of ground and ball"):
        stepper(scene_mechanism("bouncing-ball/half").mechanism)
    settings = method("drake/tamsi").settings
    with pytest.raises(Unsupported, match="loop pin, which TAMSI does not support"):
        stepper(scene_mechanism("four-bar/crank-rocker").mechanism, settings)


def test_an_armature_is_an_inertia():
    """A rotor of twice the inertia keeps its velocity, and a torque moves it half as fast."""
    xml = """<mujoco><worldbody><body><joint name="a" armature="{}"/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 {}"/></body></worldbody>
      <actuator><motor joint="a"/></actuator></mujoco>"""
    velocities = []
    for armature, moment in ((1.0, 1.0), (0.0, 2.0)):
        model = mujoco.MjModel.from_xml_string(xml.format(armature, moment))
        made = stepper(compiled_mechanism(model))
        made.put(State(np.zeros(1), np.array([3.0])))
        made.advance(None, 100)
        assert made.state().qvel == pytest.approx(3.0, rel=1e-13)
        made.advance(np.full((100, 1), 5.0), 100)
        velocities.append(made.state().qvel[0])
    assert velocities == pytest.approx([3.0 + 5.0 / 2.0 * 100 * STEP] * 2, rel=1e-13)


def test_each_pair_has_its_friction():
    """Two balls slide on a floor, each with a friction of its own, and pass through each other."""
    body = """<body name="{0}"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
      <geom name="{0}" size="0.1" mass="1" contype="0" conaffinity="0" pos="0 0 0.1"/></body>"""
    pair = '<pair geom1="p" geom2="{}" friction="{} {}"/>'
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{FLOOR.format('')}{body.format('a')}{body.format('b')}</worldbody>"
        f"<contact>{pair.format('a', 0.1, 0.1)}{pair.format('b', 0.5, 0.5)}</contact></mujoco>"
    )
    made = stepper(compiled_mechanism(model))
    made.put(State(np.zeros(4), np.array([2.0, 0, -2.0, 0])))
    made.advance(None, 100)
    slowed = 9.81 * 100 * STEP * np.array([0.1, -0.5])
    # A contact yields by 20 micrometres: until then its force is not the weight, 10 mm/s in all.
    np.testing.assert_allclose(made.state().qvel[[0, 2]], [2.0, -2.0] - slowed, atol=1e-2)


@pytest.mark.parametrize("shape", ["sphere", "box", "capsule", "cylinder", "ellipsoid"])
def test_each_shape_rests_on_a_plane(shape):
    size = {"sphere": "0.1", "capsule": "0.1 0.2", "cylinder": "0.1 0.2"}
    height = {"sphere": 0.1, "box": 0.3, "ellipsoid": 0.3}.get(shape, 0.2)
    height += 0.1 if shape == "capsule" else 0.0
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{FLOOR.format('')}<body pos='0 0 {height}'>"
        "<joint type='slide' axis='0 0 1'/>"
        f"<geom name='g' type='{shape}' mass='1' size='{size.get(shape, '0.1 0.2 0.3')}'/>"
        f"</body></worldbody></mujoco>"
    )
    made = stepper(compiled_mechanism(model))
    made.put(State(np.array([1e-4]), np.zeros(1)))
    made.advance(None, 300)
    # A kilogram presses a contact of 5e5 N/m in by 20 micrometres.
    assert made.state().qpos[0] == pytest.approx(-2e-5, abs=1e-5)


def test_a_limit_stops_a_joint():
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><option gravity="0 0 0"/><worldbody><body>
        <joint axis="0 0 1" limited="true" range="-1 0.3" ref="0.1"/>
        <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody>
        <compiler angle="radian"/></mujoco>"""
    )
    made = stepper(compiled_mechanism(model))
    made.put(State(np.array([0.2]), np.array([2.0])))
    made.advance(None, 200)
    # A limit yields by what a body moves in a step or two.
    assert made.state().qpos[0] == pytest.approx(0.3, abs=4e-3)


def drift(settings):
    """How far a cube that friction holds on an incline moves in 50 ms, from rest on it."""
    from plumbob.engines.adapters.drake.scenes import with_settled_start

    parts = with_settled_start(scene_mechanism("incline/rest"), settings)
    made = stepper(parts.mechanism, settings)
    made.put(parts.start)
    return stepped(made, parts, 50).qpos[0] - parts.start.qpos[0]


def test_a_body_that_should_stick_drifts_in_proportion_to_the_stiction_tolerance():
    coarse, fine = (drift({"stiction_tolerance": speed}) for speed in (1e-3, 1e-4))
    # Friction is v/sqrt(v^2 + s^2) of what it may be, s the tolerance: 0.9 of that at 2.06 s, which
    # the cube has after 2 ms.
    assert coarse == pytest.approx(0.9 / 0.19**0.5 * 1e-3 * 50 * STEP, rel=0.05)
    assert coarse / fine == pytest.approx(10.0, rel=0.05)


def test_bodies_that_stand_on_a_plane_start_at_rest_on_their_contacts():
    """The static penetration of a stack is the weights over 5e5 N/m a contact; a disc that leans,
    and would fall, starts as it is."""
    from plumbob.engines.adapters.drake.scenes import with_settled_start

    parts = scene_mechanism("stack/equal")
    lower = (parts.start.qpos - with_settled_start(parts, {}).start.qpos).tolist()
    masses = np.array([body.mass for body in parts.mechanism.bodies[1:]])
    carried = 9.81 * np.cumsum(masses[::-1])[::-1]
    # The depth of two boxes in each other is found to 1e-11 m or so.
    assert lower == pytest.approx(np.cumsum(carried / 5e5).tolist(), abs=1e-10)
    falling = scene_mechanism("rolling-disc/circle")
    assert with_settled_start(falling, {}) is falling
