"""A mechanism's records hold what MuJoCo's equations of motion hold: the same mass matrix and the
same forces in random states, worked out from the records alone."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
from plumbob.engines.adapters.mujoco.options import collected
from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.mechanism import idealised
from plumbob.engines.registry import method
from plumbob.models.idealisations import Idealisations
from plumbob.models.registry import built_in_systems, case_of, scene
from plumbob.tests.audit.robots.robot_files import folder
from plumbob.tests.support.mechanism_terms import terms

# Sums of tens of products in double precision, which cancel by a factor of a thousand at most.
CLOSE = 1e-12
STATES = 5
EULER = method("mujoco/euler")
# Files of two packages, fixed beforehand, and the parts that a mechanism has no records for.
FILES = {
    "gymnasium": {
        "ant": "",
        "half_cheetah": "",
        "hopper": "",
        "humanoid": "tendon left_hipknee, tendon right_hipknee",
        "humanoidstandup": "tendon left_hipknee, tendon right_hipknee",
        "inverted_double_pendulum": "",
        "inverted_pendulum": "",
        "point": "",
        "pusher": "",
        "pusher_v5": "",
        "reacher": "",
        "swimmer": "drag of the medium",
        "walker2d": "",
        "walker2d_v5": "",
    },
    "dm_control": {
        "acrobot": "",
        "ball_in_cup": "tendon string",
        "cartpole": "",
        "cheetah": "",
        "finger": "",
        "fish": "actuator fins_flap, tendon fins_flap, tendon fins_sym, drag of the medium",
        "hopper": "",
        "humanoid": "",
        "humanoid_CMU": "",
        "lqr": "",
        "manipulator": "equality coupling, actuator grasp, tendon grasp, tendon coupling",
        "pendulum": "",
        "point_mass": "actuator t1, actuator t2, tendon t1, tendon t2",
        "quadruped": "29 parts",
        "swimmer": "drag of the medium",
        "walker": "",
    },
}
SYSTEMS = sorted(built_in_systems())
TURNING = ("capsule-turn/heading-030", "cone-pendulum/rotating-base")


def largest_difference(model, mechanism, seed=0):
    """The largest difference of each term between MuJoCo and the records over random states,
    relative to the term's largest number; the bias, whose parts may cancel, to the size of its
    parts, too."""
    data = mujoco.MjData(model)
    rng = np.random.default_rng(seed)
    worst = dict.fromkeys(("mass matrix", "bias", "passive", "actuator"), 0.0)
    for _ in range(STATES):
        data.qpos[:] = model.qpos0
        mujoco.mj_integratePos(model, data.qpos, rng.normal(size=model.nv), 1.0)
        data.qvel[:] = rng.normal(size=model.nv)
        data.ctrl[:] = 2.0 * rng.normal(size=model.nu)
        with collected():
            mujoco.mj_forward(model, data)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        forces = (data.qfrc_bias, data.qfrc_passive, data.qfrc_actuator)
        records = terms(mechanism, data.qpos, data.qvel, data.ctrl)
        for name, expected in zip(worst, (mass, *forces), strict=True):
            size = np.abs(expected).max(initial=0.0)
            if name == "bias":
                moved = np.abs(mass - np.diag(model.dof_armature)).max(initial=0.0)
                size = max(size, moved * np.square(data.qvel).max(initial=0.0))
            size = size or 1.0
            difference = np.abs(records[name] - expected).max(initial=0.0) / size
            worst[name] = max(worst[name], difference)
    return worst


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_records_of_a_system_give_mujoco_s_terms(name):
    system = built_in_systems()[name]
    model = compiled(case_of(scene(f"{name}/{system.default}")), EULER, 1e-3).model
    mechanism = compiled_mechanism(model)
    assert not mechanism.not_expressed
    assert max(largest_difference(model, mechanism).values()) <= CLOSE


def terms_of(model, parts):
    """The terms to which parts without a record contribute. A tendon's forces of actuators belong
    to the actuators."""
    terms = set()
    for part in parts:
        kind, _, name = part.name.partition(" ")
        if kind == "tendon":
            tendon = model.tendon(name).id
            terms |= {"mass matrix", "bias"} if model.tendon_armature[tendon] else set()
            sprung = model.tendon_stiffness[tendon] or model.tendon_damping[tendon]
            terms |= {"passive"} if sprung else set()
        terms |= {"drag": {"passive"}, "actuator": {"actuator"}}.get(kind, set())
    return terms


@pytest.mark.parametrize("package", FILES)
@pytest.mark.long(keep=1)
def test_the_records_of_public_files_give_mujoco_s_terms(package, capfd):
    assets = folder(package)
    if assets is None:
        pytest.skip(f"{package} is not installed: its model files are read here")
    for name, parts in FILES[package].items():
        model = mujoco.MjModel.from_xml_path(str(assets / f"{name}.xml"))
        mechanism = compiled_mechanism(model)
        missing = mechanism.not_expressed
        names = ", ".join(part.name for part in missing)
        assert names == parts or f"{len(missing)} parts" == parts, (name, names)
        open_terms = terms_of(model, missing)
        for term, difference in largest_difference(model, mechanism).items():
            assert difference <= CLOSE or term in open_terms, (name, term, difference)


@pytest.mark.parametrize(
    ("element", "field", "factor"),
    [
        ("bodies", "mass", 1.0 + 1e-9),
        ("joints", "stiffness", 1.0 + 1e-9),
        ("actuators", "gear", 1.0 + 1e-9),
    ],
)
def test_a_number_that_is_wrong_by_1e_9_is_noticed(element, field, factor):
    xml = """<mujoco><worldbody><body><joint name="a" stiffness="3" damping="1" springref="20"/>
      <geom size="0.1" mass="1" pos="0 1 1"/></body></worldbody>
      <actuator><motor joint="a" gear="2"/></actuator></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    mechanism = compiled_mechanism(model)
    assert max(largest_difference(model, mechanism).values()) <= CLOSE
    changed = tuple(
        replace(part, **{field: factor * getattr(part, field)})
        for part in getattr(mechanism, element)
    )
    wrong = replace(mechanism, **{element: changed})
    assert max(largest_difference(model, wrong).values()) > CLOSE


def test_a_prescribed_joint_has_its_velocity_in_place_of_armature_and_motor():
    case = case_of(scene("capsule-line/heading-030"))
    mechanism = compiled_mechanism(compiled(case, EULER, 1e-3).model)
    assert mechanism.joints[-1].armature[0] > 1e9
    ideal = idealised(mechanism, case.system.model_file.ideal(case.problem))
    assert ideal.joints[-1].armature[0] == 0.0
    assert not ideal.actuators
    assert ideal.bodies[-1].point
    times = np.array([0.0, 0.01, 0.02])
    expected = case.reference.observe(times)["stroke_rate"]
    np.testing.assert_allclose(ideal.joints[-1].velocity(times), expected, atol=1e-15)


def test_the_restitution_of_a_system_is_in_its_mechanism():
    case = case_of(scene("bouncing-ball/half"))
    mechanism = compiled_mechanism(compiled(case, EULER, 1e-3).model)
    (touch,) = idealised(mechanism, case.system.model_file.ideal(case.problem)).touching
    assert touch.restitution == case.problem.restitution == 0.5


def test_an_idealisation_of_a_name_that_is_not_there_is_refused():
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    with pytest.raises(KeyError, match="pin is not one of"):
        idealised(compiled_mechanism(model), Idealisations(rigid_loops=("pin",)))
