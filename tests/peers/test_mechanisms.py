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
from plumbob.tests.peers.test_dart_mechanisms import (
    ALL_JOINTS,
    BALL,
    FLOOR,
    PAIR,
    default,
    model_and_mechanism,
    scene_mechanism,
)
from plumbob.tests.peers.test_dart_mechanisms import stepper as dart_stepper
from plumbob.tests.peers.test_smooth_peers import needed
from plumbob.tests.support.built_mechanisms import (
    assert_nothing_survives_put,
    largest_difference_of_terms,
    opening_of_a_loop,
)

STEP = 1e-3  # [s]
# Sums of tens of products in double precision, which cancel by a factor of a thousand at most.
CLOSE = 1e-12
TREES = (
    *("projectile", "simple-pendulum", "linear-pendulum", "cone-pendulum", "n-pendulum"),
    *("heavy-top", "servo", "free-body"),
)
LOOPS = ("four-bar", "slider-crank")
CAPSULES = ("capsule-plan", "capsule-train", "capsule-turn")


def exudyn(mechanism, start, how="exudyn/default", controls=None):
    from plumbob.engines.adapters.exudyn.stepper import ExudynStepper

    return ExudynStepper(mechanism, find_method(how).settings, STEP, controls)


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


def pybullet(mechanism, start):
    from plumbob.engines.adapters.pybullet.stepper import BulletStepper

    return BulletStepper(mechanism, find_method("pybullet/undamped+iterated").settings, STEP)


def drake(mechanism, start):
    from plumbob.engines.adapters.drake.stepper import DrakeStepper

    return DrakeStepper(mechanism, {"time_step": STEP}, STEP)


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
    "pinocchio": Subject("pinocchio/aba+rk4", pinocchio, pinocchio_s_terms, (*TREES, *LOOPS)),
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
    changed = change(replace(mechanism, joints=free))
    made = subject.stepper(changed, start)
    return largest_difference_of_terms(model, changed, made, subject.terms)


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
    assert_nothing_survives_put(lambda: make(parts.mechanism, parts.start), parts)


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
    },
    "pinocchio": {
        "drag of the medium": (ONE.format(""), '<option viscosity="1"/>'),
        "contact of p and g": (FLOOR + BALL, PAIR.format("")),
        "limit or dry friction of joint d": (ONE.format('frictionloss="1"'), ""),
        "spring of joint d, which is a ball joint": (
            ONE.format('type="ball" stiffness="1"'),
            "",
        ),
    },
}
REFUSED = [(engine, name) for engine, own in FEATURES.items() for name in own]


@pytest.mark.parametrize(("engine", "feature"), REFUSED)
def test_a_feature_that_is_not_expressed_is_refused_by_its_name(engine, feature):
    bodies, rest = (part.replace("{}", "") for part in FEATURES[engine][feature])
    xml = f"<mujoco><worldbody>{bodies}</worldbody>{rest}</mujoco>"
    mechanism = compiled_mechanism(mujoco.MjModel.from_xml_string(xml))
    with pytest.raises(Unsupported, match=feature):
        found(engine).stepper(mechanism, None)


@dataclass(frozen=True)
class LoopEngine:
    """An engine that keeps two bodies together."""

    method: str
    stepper: Callable
    tolerance: float  # [m] or [1], of a loop that two bodies turn with by 3.7 rad/s


LOOP_ENGINES = {
    # The arm of 0.5 m turns by 3.7 mrad in a step, whose velocity goes straight on: that opens a
    # loop by 3.4e-6 m. DART closes 1 % of a gap in a step, PyBullet 20 %, Drake more.
    "dart": LoopEngine("dart/default", dart_stepper, 5e-4),
    "pybullet": LoopEngine("pybullet/undamped+iterated", pybullet, 2e-5),
    "drake": LoopEngine("drake/default", drake, 1e-5),
    # Exudyn constrains positions, by Newton's method: rounding is left.
    "exudyn": LoopEngine("exudyn/default", exudyn, 1e-12),
    # RK4's error of half a second at steps of 1 ms.
    "pinocchio": LoopEngine("pinocchio/aba+rk4", pinocchio, 1e-9),
}


@pytest.mark.parametrize("kind", ["weld", "connect"])
@pytest.mark.parametrize("engine", LOOP_ENGINES)
def test_a_loop_keeps_two_free_bodies_together(engine, kind):
    """A weld keeps the relative pose of two bodies, a ball joint their point alone."""
    closer = LOOP_ENGINES[engine]
    needed(closer.method)
    gap, turned = opening_of_a_loop(closer.stepper, kind)
    assert gap <= closer.tolerance
    assert (turned <= closer.tolerance) == (kind == "weld")


@pytest.mark.parametrize("engine", LOOP_ENGINES)
def test_a_loop_in_a_wrong_place_is_noticed(engine):
    """A point of the loop that is twice the tolerance from its place opens the loop by more than
    the tolerance. DART refuses such a loop."""
    closer = LOOP_ENGINES[engine]
    needed(closer.method)
    off = 2.0 * closer.tolerance
    if engine == "dart":
        with pytest.raises(Unsupported, match="open at the start"):
            opening_of_a_loop(closer.stepper, "weld", off)
    else:
        gap, _ = opening_of_a_loop(closer.stepper, "weld", off)
        assert gap > closer.tolerance
