"""Mechanisms in DART: MuJoCo's mass matrix and forces, nothing that survives `put`, and names of
what DART does not express."""

from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest

from plumbob.engines.abilities import CompilesScenes
from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
from plumbob.engines.adapters.mujoco.options import compiled
from plumbob.engines.adapters.mujoco.translation import filled
from plumbob.engines.mechanism import idealised
from plumbob.engines.method import Unsupported
from plumbob.engines.registry import find_engine, method
from plumbob.engines.stepper import State
from plumbob.models.registry import built_in_systems, case_of, scene
from plumbob.tests.peers.test_smooth_peers import needed
from plumbob.tests.support.built_mechanisms import (
    assert_nothing_survives_put,
    largest_difference_of_terms,
)


@pytest.fixture(autouse=True)
def dart():
    """DART, without which these tests are skipped."""
    needed("dart/default")


# Sums of tens of products in double precision, which cancel by a factor of a thousand at most.
CLOSE = 1e-12
STEP = 1e-3  # [s]
FASTEST = 1e100  # [rad/s]: a rate so large is no motion of a mechanism
SYSTEMS = sorted(built_in_systems())
AT_REST = State(np.zeros(1), np.zeros(1))
ALL_JOINTS = """<mujoco><compiler angle="radian"/>
  <option gravity="0.3 0.2 -9.81"/>
  <worldbody>
    <body pos="1 0 0.5" quat="0.9 0.1 0.2 0.3">
      <joint name="a" type="slide" axis="1 1 0" ref="0.2" stiffness="3" springref="0.1"
             damping="2"/>
      <joint name="b" axis="0 1 1" pos="0.1 0.2 0.3" ref="0.4" stiffness="5" springref="0.7"/>
      <joint name="c" axis="1 0 0" pos="0 0.1 0" armature="0.3" damping="0.1"/>
      <inertial pos="0.1 0 0.2" mass="2" fullinertia="0.3 0.2 0.25 0.01 0.02 0.03"/>
      <body pos="0 0.3 0" gravcomp="1">
        <inertial pos="0 0 0.1" mass="0.5" diaginertia="0.02 0.03 0.04"/>
        <body pos="0.2 0 0.1" quat="1 0.3 0 0">
          <joint name="d" type="ball" pos="0 0 0.2" damping="0.4"/>
          <inertial pos="0.1 0.1 0" mass="1" diaginertia="0.1 0.2 0.15"/>
        </body>
      </body>
    </body>
    <body pos="0 0 2">
      <freejoint/>
      <inertial pos="0.1 0.2 0.3" mass="3" diaginertia="0.5 0.4 0.3"/>
      <body pos="0 0.3 0">
        <joint name="e" axis="0 0 1"/>
        <inertial pos="0.2 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position joint="b" kp="7" kv="0.5" forcerange="-2 2"/>
    <motor joint="e" gear="3" ctrlrange="-1 1"/>
  </actuator>
</mujoco>"""


def stepper(mechanism, start, solver=None):
    from plumbob.engines.adapters.dart.stepper import DartStepper

    return DartStepper(mechanism, start, STEP, solver)


@cache
def scene_mechanism(name):
    return find_engine("mujoco").ability(CompilesScenes).mechanism(case(name))


@cache
def case(name):
    return case_of(scene(name))


def default(system):
    return f"{system}/{built_in_systems()[system].default}"


def model_and_mechanism(name):
    """A system's model without the armatures by which it prescribes motions, and its mechanism."""
    if name == "all joints":
        model = mujoco.MjModel.from_xml_string(ALL_JOINTS)
        return model, compiled_mechanism(model), State(model.qpos0, np.zeros(model.nv))
    problem, system = case(default(name)).problem, built_in_systems()[name]
    file = system.model_file
    model = compiled(filled(system.mjcf, file, problem))
    ideal = file.ideal(problem)
    for joint in ideal.velocities:
        model.dof_armature[model.joint(joint).dofadr] = 0.0
    start = model.key("start")
    mechanism = idealised(compiled_mechanism(model), ideal)
    return model, mechanism, State(np.array(start.qpos), np.array(start.qvel))


def skeletons_of(made):
    """DART's skeletons, one for each tree of bodies."""
    return list(dict.fromkeys(node.getSkeleton() for node in made.built.nodes if node))


def degrees(made, mechanism, qpos):
    """The index of each of MuJoCo's degrees of freedom among those of DART's skeletons, and the
    matrix by which DART's rates follow from MuJoCo's, joint by joint."""
    skeletons = skeletons_of(made)
    counts = np.cumsum([0, *(skeleton.getNumDofs() for skeleton in skeletons)])
    begins = {x.getName(): first for x, first in zip(skeletons, counts, strict=False)}
    order, turns, first = [], [], 0
    for joint, of_dart in zip(mechanism.joints, made.built.joints, strict=True):
        degrees_of = of_dart.getNumDofs()
        begin = begins[of_dart.getSkeleton().getName()] + of_dart.getIndexInSkeleton(0)
        order += range(begin, begin + degrees_of)
        turn = np.eye(degrees_of)
        if joint.kind == "free":
            flat = np.zeros(9)
            mujoco.mju_quat2Mat(flat, qpos[first + 3 : first + 7])
            turn = np.block(
                [[np.zeros((3, 3)), flat.reshape(3, 3)], [np.eye(3), np.zeros((3, 3))]]
            )
        turns.append(turn)
        first += {"ball": 4, "free": 7}.get(joint.kind, 1)
    return order, turns


def block_diagonal(blocks):
    from scipy.linalg import block_diag

    return block_diag(*blocks)


def terms(made, mechanism, qpos, controls):
    """DART's mass matrix, bias, passive and actuator forces, along MuJoCo's degrees of freedom."""
    order, turns = degrees(made, mechanism, qpos)
    turn = block_diagonal(turns)
    parts = skeletons_of(made)
    mass = block_diagonal([x.getMassMatrix() for x in parts])[np.ix_(order, order)]
    bias = np.concatenate([x.getCoriolisAndGravityForces() for x in parts])[order]
    dofs = [x.getDof(i) for x in parts for i in range(x.getNumDofs())]
    passive = np.array(
        [
            -dof.getDampingCoefficient() * dof.getVelocity()
            - dof.getSpringStiffness() * (dof.getPosition() - dof.getRestPosition())
            for dof in dofs
        ]
    )[order]
    mass, forces = turn.T @ mass @ turn, [turn.T @ part for part in (bias, passive)]
    actuators = np.zeros(len(mass))
    for motor in made.motors:
        at = made.built.joints.index(motor.joint)
        degree = sum(x.getNumDofs() for x in made.built.joints[:at])
        # the damper that stands for an armature, which a force takes back
        rate = motor.joint.getVelocity(0)
        mass[degree, degree] += motor.rotor * made.step
        forces[1][degree] += motor.rotor * rate
        actuators[degree] = motor.force(controls.tolist()) - motor.rotor * rate
    return mass, *forces, actuators


def largest_difference(name, change=lambda mechanism: mechanism):
    model, mechanism, start = model_and_mechanism(name)
    made = stepper(change(mechanism), start)
    return largest_difference_of_terms(model, mechanism, made, terms)


@pytest.mark.parametrize("name", [*SYSTEMS, "all joints"])
def test_a_mechanism_in_dart_has_mujoco_s_mass_matrix_and_forces(name):
    assert largest_difference(name) <= CLOSE


@pytest.mark.parametrize(
    ("part", "field", "factor"),
    [
        ("bodies", "mass", 1.0 + 1e-9),
        ("bodies", "place", 1.0 + 1e-9),
        ("joints", "stiffness", 1.0 + 1e-9),
        ("joints", "armature", 1.0 + 1e-9),
        ("actuators", "gain", 1.0 + 1e-9),
    ],
)
def test_a_number_that_is_wrong_by_1e_9_is_noticed(part, field, factor):
    def change(mechanism):
        parts = getattr(mechanism, part)
        changed = [replace(x, **{field: factor * getattr(x, field)}) for x in parts]
        return replace(mechanism, **{part: tuple(changed)})

    assert largest_difference("all joints", change) > CLOSE


def nsgs():
    from plumbob.engines.adapters.dart.simulation import nsgs as solver

    return solver(method("dart/nsgs").settings["tolerance"])


CASES = [(default(name), None) for name in SYSTEMS]
# A solver that begins with the impulses of its last step changes velocities by 6e-10 m/s there.
CASES.append(("capsule-line/heading-030", nsgs))


@pytest.mark.parametrize(("name", "solver"), CASES)
def test_put_and_step_equals_fresh_and_step_to_the_bit(name, solver):
    parts = scene_mechanism(name)
    assert_nothing_survives_put(lambda: stepper(parts.mechanism, parts.start, solver), parts)


BALL = '<body name="b"><freejoint name="f"/><geom name="g" size="0.1" {}/></body>'
FLOOR = '<geom name="p" type="plane" size="1 1 1" {}/>'
HINGED = """<body name="{0}" {1}><joint name="{0}" {2}/>
<geom size="1" contype="0" conaffinity="0"/></body>"""
PAIR = '<contact><pair geom1="p" geom2="g" {}/></contact>'
APART = (("world", "b"), ("world", "c"), ("b", "c"))
FEATURES = {
    "partly carried weight of body b": (
        '<body name="b" gravcomp="0.5"><joint/><geom size="1"/></body>',
        "",
    ),
    "drag of the medium": ('<body><joint/><geom size="1"/></body>', '<option viscosity="1"/>'),
    "torsional or rolling friction of p and g": (FLOOR + BALL, PAIR.format('condim="4"')),
    "friction of p and g, different along two directions": (
        FLOOR + BALL,
        PAIR.format('friction="1 0.5"'),
    ),
    "friction of p and g, 0.001 or less": (FLOOR + BALL, PAIR.format('friction="1e-3 1e-3"')),
    "contact of two bodies of which only some shapes touch": (
        FLOOR
        + BALL.replace("/></body>", '/><geom name="h" size="0.2"/></body>')
        + '<body name="c"><freejoint/><geom name="q" size="0.1"/></body>',
        "".join(f'<contact><exclude body1="{x}" body2="{y}"/></contact>' for x, y in APART)
        + PAIR
        + '<contact><pair geom1="q" geom2="h" condim="1"/></contact>',
    ),
    "spring, limit or dry friction of joint s, which is a ball joint": (
        '<body><joint name="s" type="ball" stiffness="1"/><geom size="1"/></body>',
        "",
    ),
    "armature of joint a, beside contacts, loops, limits or dry friction": (
        HINGED.format("a", "", 'armature="1" limited="true" range="-1 1"'),
        "",
    ),
    "loop l, which is open at the start": (
        HINGED.format("a", "", "") + HINGED.format("b", 'pos="1 0 0"', ""),
        '<equality><weld name="l" body1="a" body2="b" relpose="2 0 0 1 0 0 0"/></equality>',
    ),
}


@pytest.mark.parametrize("feature", FEATURES)
def test_a_feature_that_is_not_expressed_is_refused_by_its_name(feature):
    bodies, rest = (part.replace("{}", "") for part in FEATURES[feature])
    xml = f"<mujoco><worldbody>{bodies}</worldbody>{rest}</mujoco>"
    model = mujoco.MjModel.from_xml_string(xml)
    with pytest.raises(Unsupported, match=feature):
        stepper(compiled_mechanism(model), State(model.qpos0, np.zeros(model.nv)))


def test_an_armature_adds_no_damping():
    """A free rotor of twice the inertia keeps its velocity, and a torque moves it half as fast."""
    xml = """<mujoco><worldbody><body><joint name="a" armature="{}"/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 {}"/></body></worldbody>
      <actuator><motor joint="a"/></actuator></mujoco>"""
    velocities = []
    for armature, moment in ((1.0, 1.0), (0.0, 2.0)):
        model = mujoco.MjModel.from_xml_string(xml.format(armature, moment))
        made = stepper(compiled_mechanism(model), State(np.zeros(1), np.array([3.0])))
        made.advance(None, 100)
        assert made.state().qvel == pytest.approx(3.0, rel=1e-13)
        made.advance(np.full((100, 1), 5.0), 100)
        velocities.append(made.state().qvel[0])
    # Each step rounds a damper's force 1000 times as large as the torque.
    assert velocities == pytest.approx([3.0 + 5.0 / 2.0 * 100 * STEP] * 2, rel=1e-11)


@pytest.mark.parametrize(
    ("torque", "rate"), [(5.0, 3.0), (1.0, 0.0), (-1.5, 0.0), (-4.0, -2.0)]
)
def test_dry_friction_takes_its_largest_torque_or_holds(torque, rate):
    xml = """<mujoco><worldbody><body><joint name="a" frictionloss="2"/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 0.1"/></body></worldbody>
      <actuator><motor joint="a"/></actuator></mujoco>"""
    made = stepper(compiled_mechanism(mujoco.MjModel.from_xml_string(xml)), AT_REST)
    made.advance(np.full((100, 1), torque), 100)
    # Constraints of DART are softer than rigid ones by 1e-9 and less.
    assert made.state().qvel == pytest.approx(rate, abs=1e-6)


def test_a_limit_stops_a_joint_of_which_the_drawing_has_another_coordinate():
    xml = """<mujoco><worldbody><body><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
      <joint type="slide" axis="0 0 -1" limited="true" range="0.3 0.5" ref="0.4"/></body>
      </worldbody></mujoco>"""
    made = stepper(compiled_mechanism(mujoco.MjModel.from_xml_string(xml)), AT_REST)
    made.put(State(np.array([0.4]), np.zeros(1)))
    made.advance(None, 300)
    # It passes the limit by a step of its speed of 1.4 m/s at most.
    assert made.state().qpos == pytest.approx(0.5, abs=2e-3)
    assert made.state().qvel == pytest.approx(0.0, abs=1e-2)


def fallen(restitution):
    parts = scene_mechanism("bouncing-ball/half")
    touching = tuple(replace(x, restitution=restitution) for x in parts.mechanism.touching)
    mechanism = replace(parts.mechanism, touching=touching, gravity=np.zeros(3))
    made = stepper(mechanism, State(np.array([0.101]), np.array([-2.0])))
    made.advance(None, 2)
    return made.state().qvel[0]


@pytest.mark.parametrize("restitution", [0.0, 0.36, 1.0])
def test_a_ball_bounces_with_the_restitution_of_its_pair(restitution):
    # A contact is found up to 2 mm deep, and pushes 1 % of that out in a step: up to 0.02 m/s.
    assert fallen(restitution) == pytest.approx(2.0 * restitution, abs=2e-2)


def test_each_pair_has_its_friction():
    """Two balls slide on a floor, each with a friction of its own, and pass through each other."""
    body = """<body name="{0}"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
      <geom name="{0}" size="0.1" mass="1" contype="0" conaffinity="0" pos="0 0 0.1"/></body>"""
    pair = '<pair geom1="p" geom2="{}" friction="{} {}"/>'
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{FLOOR.format('')}{body.format('a')}{body.format('b')}</worldbody>"
        f"<contact>{pair.format('a', 0.1, 0.1)}{pair.format('b', 0.5, 0.5)}</contact></mujoco>"
    )
    made = stepper(compiled_mechanism(model), State(np.zeros(4), np.array([2.0, 0, -2.0, 0])))
    made.advance(None, 100)
    slowed = 9.81 * 100 * STEP * np.array([0.1, -0.5])
    np.testing.assert_allclose(made.state().qvel[[0, 2]], [2.0, -2.0] - slowed, atol=1e-4)


@pytest.mark.parametrize(("heavier", "step"), [(1.0, 1.0), (1.0, 0.01), (1e30, 0.1)])
def test_a_run_whose_accelerations_are_not_finite_is_lost(heavier, step):
    """DART leaves out forces and accelerations that are not finite: all numbers of the run stay
    finite, to its end. A heavier body reaches forces that are not finite at a lower rate."""
    top = scene("heavy-top/nutating")
    masses = ("mass", "inertia_across", "inertia_axis")
    heavy = {name: heavier * top.parameters[name] for name in masses}
    case = case_of(replace(top, parameters={**top.parameters, **heavy})).lasting(30.0)
    run = find_engine("dart").prepare(case, method("dart/default"), step).run()
    assert run.diverged_at is not None
    assert max(np.abs(values).max() for values in run.observables.values()) < FASTEST


def test_a_run_that_is_lost_prints_nothing(capfd):
    """DART prints several lines a step where numbers are not finite: of this run 12,000."""
    case = case_of(scene("heavy-top/nutating")).lasting(3000.0)
    find_engine("dart").prepare(case, method("dart/default"), 1.0).run()
    assert capfd.readouterr() == ("", "")
