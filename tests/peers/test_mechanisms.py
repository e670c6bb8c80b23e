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
    ALL_JOINTS,
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
CAPSULES = ("capsule-plan", "capsule-train", "capsule-turn")
LASTING = 10.0  # [s], longer than any run here


def exudyn(mechanism, start, how="exudyn/default", controls=None):
    from plumbob.engines.adapters.exudyn.stepper import ExudynStepper

    return ExudynStepper(mechanism, find_method(how).settings, STEP, LASTING, controls)


def exudyn_s_terms(made, mechanism, qpos, controls):
    """The mass matrix, bias, passive and actuator forces, whose rates are MuJoCo's: forces of the
    mechanism, and of that without what acts on its joints."""
    import exudyn as package

    def total(parts, row=None):
        own = exudyn(parts, None, controls=row)
        own.put(made.state())
        solver = package.MainSolverImplicitSecondOrder()
        solver.InitializeSolver(own.built.system, own._options(1))
        solver.ComputeMassMatrix(own.built.system)
        solver.ComputeODE2RHS(own.built.system)
        return np.array(solver.GetSystemMassMatrix()), np.array(solver.GetSystemResidual())

    without = replace(mechanism, actuators=())
    loose = [
        replace(x, stiffness=0.0, damping=np.zeros_like(x.damping)) for x in mechanism.joints
    ]
    mass, forces = total(mechanism, lambda times: np.tile(controls, (len(times), 1)))
    moved = total(without)[1]
    bare = total(replace(without, joints=tuple(loose)))[1]
    own = slice(len(made.state().qvel))  # multipliers of loops are behind them
    return mass[own, own], -bare[own], (moved - bare)[own], (forces - moved)[own]


@dataclass(frozen=True)
class Subject:
    """An engine in these tests."""

    method: str
    stepper: Callable
    terms: Callable
    systems: tuple[str, ...]  # whose terms are MuJoCo's, and of which nothing survives `put`
    others: tuple[str, ...] = ()  # of which nothing survives `put`
    joints: str = ALL_JOINTS  # a model with all kinds of joints and forces that the engine has


ENGINES = {
    "exudyn": Subject(
        "exudyn/default",
        exudyn,
        exudyn_s_terms,
        (*TREES, *LOOPS, "capsule-coast", "incline", "rolling-disc"),
        (*("bouncing-ball", "rolling-ball", "capsule-hold", "capsule-line"), *CAPSULES),
        ALL_JOINTS.replace('gravcomp="1"', "")
        .replace('type="ball"', "")
        .replace("<freejoint/>", '<joint name="f" pos="0.1 0 0"/>'),
    ),
}
PAIRS = [(engine, name) for engine, own in ENGINES.items() for name in own.systems]
OTHERS = [(engine, name) for engine, own in ENGINES.items() for name in own.others]


@pytest.fixture(params=ENGINES)
def subject(request):
    return found(request.param)


def found(engine):
    """An engine, without which a test is skipped."""
    needed(ENGINES[engine].method)
    return ENGINES[engine]


def largest_difference(subject, name, change=lambda mechanism: mechanism):
    if name == "all joints":
        model = mujoco.MjModel.from_xml_string(subject.joints)
        mechanism, start = compiled_mechanism(model), State(model.qpos0, np.zeros(model.nv))
    else:
        model, mechanism, start = model_and_mechanism(name)
    free = tuple(replace(joint, velocity=None) for joint in mechanism.joints)
    made = subject.stepper(change(replace(mechanism, joints=free)), start)
    return largest_difference_of_terms(model, made.mechanism, made, subject.terms)


@pytest.mark.long(keep=4)
@pytest.mark.parametrize(
    ("engine", "name"), [*((engine, "all joints") for engine in ENGINES), *PAIRS]
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


@pytest.mark.long(keep=4)
@pytest.mark.parametrize(("engine", "name"), [*OTHERS, *PAIRS])
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
ROLLS = PAIR.format('condim="6"')
FEATURES = {
    "exudyn": {
        "drag of the medium": (ONE.format(""), '<option viscosity="1"/>'),
        "carried weight of body b": (
            '<body name="b" gravcomp="1"><joint/><geom size="1"/></body>',
            "",
        ),
        "limit or dry friction of joint d": (ONE.format('frictionloss="1"'), ""),
        "spring, damper or armature of joint d, which is a ball joint": (
            ONE.format('type="ball" stiffness="1"'),
            "",
        ),
        "torsional or rolling friction of p and g": (FLOOR + BALL, ROLLS),
        "contact of p and g": (FLOOR + BALL.replace("<joint", "<freejoint"), PAIR.format("")),
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


def test_exudyn_s_explicit_solvers_refuse_what_they_would_ignore():
    needed("exudyn/rk44")
    for name, feature in (
        ("four-bar/crank-rocker", "loop pin"),
        ("incline/rest", "contacts"),
        ("capsule-line/heading-030", "changing velocity of joint slider"),
    ):
        with pytest.raises(Unsupported, match=feature):
            exudyn(scene_mechanism(name).mechanism, None, "exudyn/rk44")


TURNS_AND_CARRIES = """<mujoco><option integrator="RK4" timestep="1e-3"/><worldbody>
  <body pos="0 0 1" quat="1 0.2 0.1 0.3"><freejoint/>
    <inertial pos="0.1 0 0.05" mass="2" fullinertia="0.3 0.2 0.25 0.01 0.02 0.03"/>
    <body pos="0.1 0 0"><inertial pos="0 0 0.1" mass="0.5" diaginertia="0.01 0.02 0.02"/>
      <body pos="0.2 0 0" quat="1 0 0.2 0"><joint type="ball" pos="0 0.1 0"/>
        <inertial pos="0.1 0.1 0" mass="1" diaginertia="0.1 0.2 0.15"/></body>
    </body>
  </body>
  <body pos="3 0 1"><freejoint/>
    <inertial pos="0.1 0 0.05" mass="2" fullinertia="0.3 0.2 0.25 0.01 0.02 0.03"/></body>
</worldbody></mujoco>"""


@pytest.mark.parametrize("solver", ["exudyn/default", "exudyn/rk44"])
def test_exudyn_s_free_bodies_and_balls_move_as_mujoco_s(solver):
    """A free body that carries a ball, as hinges in Exudyn, by a body welded to it, and one free
    body by itself."""
    needed(solver)
    model = mujoco.MjModel.from_xml_string(TURNS_AND_CARRIES)
    data = mujoco.MjData(model)
    data.qvel[:] = np.random.default_rng(0).normal(size=model.nv)
    made = exudyn(compiled_mechanism(model), None, solver)
    made.put(State(data.qpos.copy(), data.qvel.copy()))
    made.advance(None, 200)
    mujoco.mj_step(model, data, 200)
    # MuJoCo's own error, of which the turns have order 2, and the default solver's, of order 2.
    np.testing.assert_allclose(made.state().qpos, data.qpos, atol=1e-5)
    np.testing.assert_allclose(made.state().qvel, data.qvel, atol=1e-4)


def test_exudyn_prescribes_a_changing_velocity():
    """A platform at the rate 2 + sin 3t, put where it is at 0.5 s and off the grid of steps."""
    needed("exudyn/default")
    parts = scene_mechanism("cone-pendulum/rotating-base")
    platform, hinge = parts.mechanism.joints
    moving = replace(platform, velocity=lambda times: 2.0 + np.sin(3.0 * times))
    for begin in (0.5, 0.50037):
        made = exudyn(replace(parts.mechanism, joints=(moving, hinge)), None)
        made.put(State(parts.start.qpos, np.array([2.0 + np.sin(3.0 * begin), 0.0])), begin)
        made.advance(None, 200)
        # Newton's method solves the constraint to 1e-8 of what it was wrong by.
        rate = 2.0 + np.sin(3.0 * (begin + 0.2))
        assert made.state().qvel[0] == pytest.approx(rate, abs=1e-9)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("name", LOOPS)
def test_exudyn_s_loops_stay_closed_and_have_order_2(name):
    needed("exudyn/default")
    scene, how = case(default(name)), find_method("exudyn/default")
    quantities = scene.system.quantities(scene)
    coarse, fine = (
        relative_error(measure(scene, how, step)[0], quantities) for step in (1e-3, 5e-4)
    )
    assert fine < 1e-3
    assert coarse / fine == pytest.approx(4.0, rel=0.1)


def test_exudyn_s_weld_keeps_two_bodies_together():
    """Two free bodies that turn as one about the first one's frame, in free space."""
    needed("exudyn/default")
    bodies = "".join(
        f'<body name="{name}" pos="{x} 0 1" quat="{quat}"><freejoint/>'
        '<inertial pos="0.1 0.1 0" mass="1" diaginertia="0.1 0.2 0.15"/></body>'
        for name, x, quat in (("a", 0.0, "1 0.2 0.3 0"), ("b", 0.5, "1 0 0.3 0.4"))
    )
    weld = '<equality><weld body1="a" body2="b"/></equality>'
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><option gravity='0 0 0'/><worldbody>{bodies}</worldbody>{weld}</mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    first, second = (data.xmat[i].reshape(3, 3).copy() for i in (1, 2))
    spin = np.array([1.0, 2.0, 3.0])
    rates = [np.zeros(3), first.T @ spin, np.cross(spin, [0.5, 0.0, 0.0]), second.T @ spin]
    made = exudyn(compiled_mechanism(model), None)
    made.put(State(model.qpos0, np.concatenate(rates)))
    made.advance(None, 500)
    data.qpos[:] = made.state().qpos
    mujoco.mj_kinematics(model, data)
    now = [data.xmat[i].reshape(3, 3) for i in (1, 2)]
    # Positions are constrained: what Newton's tolerance leaves, over the inertias, is open.
    np.testing.assert_allclose(now[0].T @ now[1], first.T @ second, atol=1e-8)
    apart = now[0].T @ (data.xpos[2] - data.xpos[1])
    np.testing.assert_allclose(apart, first.T @ [0.5, 0.0, 0.0], atol=1e-8)


@pytest.mark.parametrize("slip", [2.5, 5.0])
def test_exudyn_s_body_that_should_stick_drifts_at_a_part_of_the_slip_speed(slip, monkeypatch):
    """Friction is in proportion to a slip below `slip` times the step: at 0.9 of the slope that
    friction holds a cube slips at 0.9 of that."""
    needed("exudyn/default")
    from plumbob.engines.adapters.exudyn import contacts

    monkeypatch.setattr(contacts, "SLIP", slip)
    parts = scene_mechanism("incline/rest")
    made = exudyn(parts.mechanism, None)
    made.put(parts.start)
    # 50 ms are long enough for the fall of the first steps to be over.
    assert stepped(made, parts, 50).qvel[0] == pytest.approx(0.9 * slip * STEP, rel=1e-3)


@pytest.mark.parametrize(("steps", "wanted"), [(20.0, 0.4972), (60.0, 0.4998)])
def test_exudyn_s_ball_bounces_back_more_exactly_the_more_steps_it_takes(
    steps, wanted, monkeypatch
):
    needed("exudyn/default")
    from plumbob.engines.adapters.exudyn import contacts

    monkeypatch.setattr(contacts, "BOUNCE", steps)
    mechanism = replace(scene_mechanism("bouncing-ball/half").mechanism, gravity=np.zeros(3))
    made = exudyn(mechanism, None)
    made.put(State(np.array([0.1005]), np.array([-1.0])))
    made.advance(None, 200)
    assert made.state().qvel[0] == pytest.approx(wanted, abs=1e-4)
