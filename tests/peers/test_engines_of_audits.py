"""Other engines on plumbob's own files in an audit: the first term that differs is the one that the
study's findings name, and where it can be put right the step's own error is left."""

from pathlib import Path

import numpy as np
import pytest

import plumbob.models
from plumbob.engines.audit.engines import engine_error
from plumbob.engines.audit.term_differences import readings_of
from plumbob.engines.registry import find_engine, installed
from plumbob.engines.study.model_reading import every_field
from plumbob.reports.judge.model_readers import compared_reading
from plumbob.tests.support.engines_beside import held

FACTOR = 2.0  # of the step's own error, which is left
NOTICED = 1.1  # of what is left: the error before; of a gravity of 9.81 for 9.8 it is 1.2
# Of rounding that is predicted from the state alone: the arithmetic of a step adds to it, and both
# are sums by chance. Measured: 0.3 to 1.4.
ROUNDING = (0.1, 10.0)
ZERO = "gravity 0 0 0 for 0 0 -9.8"
MISSING = "missing: ball"
EXPECTED = (
    ("drake", "cone_pendulum", {"mass matrix": "armature dropped"}),
    (
        "drake",
        "every field",
        {"passive": "stiffness dropped", "actuator": "gear motor: 1 for 7"},
    ),
    ("drake", "n_pendulum", {}),
    ("pinocchio", "simple_pendulum", {"gravity": "gravity 0 0 -9.81 for 0 0 -9.8"}),
    ("pinocchio", "free_body", {"gravity": "gravity 0 0 -9.81 for 0 0 0"}),
    ("pinocchio", "bouncing_ball", {"contact set": MISSING}),
    ("newton", "free_body", {"gravity": "gravity 0 0 -9.81 for 0 0 0"}),
    ("dart", "n_pendulum", {"mass matrix": "inertia rod_1: 1 1 1 for"}),
    (
        "dart",
        "simple_pendulum",
        {"mass matrix": "inertia bob: 1 1 1", "gravity": "gravity 0 0 -9.81"},
    ),
    ("pybullet", "simple_pendulum", {"mass matrix": "inertia bob", "gravity": ZERO}),
    ("pybullet", "cone_pendulum", {"mass matrix": "inertia platform", "gravity": ZERO}),
)


def _on(engine, model):
    """An engine on one of plumbob's files from its first keyframe."""
    if not installed(find_engine(engine)):
        pytest.skip(f"{engine} is not installed")
    if model == "every field":
        with every_field() as file:
            text = file.read_text("utf-8").replace('frictionloss="0.05"', "")
            file.write_text(text, "utf-8")
            return engine_error(engine, held(file, control="sines", duration=0.1))
    file = Path(plumbob.models.__path__[0]) / model / f"{model}.xml"
    duration = 0.6 if model == "bouncing_ball" else 0.05 if model == "cone_pendulum" else 0.2
    return engine_error(engine, held(file, 0, duration=duration))


@pytest.mark.long
@pytest.mark.parametrize(("engine", "model", "terms"), EXPECTED)
def test_the_first_term_is_the_one_that_findings_name(engine, model, terms):
    """A cause stands for the first terms alone: those after them may follow from these."""
    result = _on(engine, model)
    assert not result.why
    found = {difference.term: difference.cause for difference in result.differences}
    assert list(found)[: len(terms)] == list(terms)
    for term, cause in terms.items():
        assert found[term].startswith(cause)
    if not terms:
        assert result.error == pytest.approx(result.step_error, rel=1e-6)
    elif "contact set" in terms:
        assert result.part_explained is None
    else:
        # Single precision rounds attitudes, too, as much as is predicted of the state's (a quarter
        # of that for Newton's free body).
        left = FACTOR * result.step_error + np.nan_to_num(result.rounding)
        assert result.all_right <= left + 1e-12
        assert result.error > NOTICED * result.all_right


@pytest.mark.long
@pytest.mark.parametrize("engine", ["mjx", "mjwarp", "newton"])
@pytest.mark.parametrize("model", ["n_pendulum"])
def test_rounding_is_all_that_tells_ports_of_mujoco_from_it(engine, model):
    result = _on(engine, model)
    assert [difference.term for difference in result.differences] == ["single precision"]
    low, high = (factor * result.rounding for factor in ROUNDING)
    assert low < result.apart < high


@pytest.mark.parametrize(
    ("engine", "model", "why"),
    [
        ("dart", "free_body", "it has 0 of 6 degrees of freedom"),
        ("dart", "cone_pendulum", "DART makes no world of it"),
        ("pybullet", "n_pendulum", "it has 0 of 3 degrees of freedom"),
        ("pinocchio", "cone_pendulum", "it refuses the file: ValueError"),
    ],
)
def test_a_file_that_an_engine_does_not_read_costs_a_line(engine, model, why):
    result = _on(engine, model)
    assert result.why.startswith(why)
    assert "\n" not in result.why
    assert result.errors.size == 0


LEANING = """<mujoco><option timestep="2e-3" cone="{cone}"/><worldbody>
<geom type="plane" size="1 1 1"/><body name="capsule"><freejoint/>
<geom type="capsule" size="0.05 0.25"/></body></worldbody><keyframe>
<key qpos="0 0 {pose}" qvel="1 0 0 0 0 0"/>
</keyframe></mujoco>"""
UPRIGHT, LYING = "0.296 0.99239 0.0868 0.0868 0", "0.0925 0.766 0.5 0.404 0"


@pytest.mark.long
@pytest.mark.parametrize(
    ("cone", "pose", "turned"),
    [("pyramidal", UPRIGHT, True), ("elliptic", UPRIGHT, False), ("pyramidal", LYING, False)],
)
def test_ports_turn_the_pyramid_of_friction_of_a_capsule_that_is_nearly_upright(
    cone, pose, turned, tmp_path
):
    """MuJoCo turns it with the capsule at any angle, its ports above 30 degrees from the normal."""
    if not installed(find_engine("mjwarp")):
        pytest.skip("mjwarp is not installed")
    (file := tmp_path / "leaning.xml").write_text(LEANING.format(cone=cone, pose=pose), "utf-8")
    result = engine_error("mjwarp", held(file, 0, duration=0.1))
    terms = [difference.term for difference in result.differences]
    assert ("friction axes" in terms) == turned, result


TUMBLING = """<mujoco model="tumbling"><option timestep="1e-3"/><worldbody>
<body name="hub" pos="0.1 0.2 0.9"><joint name="free" type="free"/>
<inertial pos="0.02 0.01 0" mass="2" diaginertia="0.03 0.02 0.04"/><geom type="sphere" size="0.1"/>
<body name="arm" pos="0.1 0.2 0.3"><joint name="hinge" type="hinge" axis="0 1 0"/>
<inertial pos="0.1 0 0" mass="1" diaginertia="0.004 0.005 0.006"/><geom type="sphere" size="0.05"/>
</body></body></worldbody>
<keyframe><key qpos="0 0 1 0.8 0.2 0.4 0.4 0.3" qvel="1 0.5 -0.2 2 -1 3 0.7"/></keyframe>
</mujoco>"""


@pytest.mark.parametrize("engine", ["drake", "pinocchio", "pybullet"])
def test_a_free_body_turns_as_in_mujoco(engine, tmp_path):
    """Engines that read this file have its equations, in each one's own coordinates; Bullet, which
    reads other moments of inertia, once these are put right."""
    if not installed(find_engine(engine)):
        pytest.skip(f"{engine} is not installed")
    (file := tmp_path / "tumbling.xml").write_text(TUMBLING, "utf-8")
    result = engine_error(engine, held(file, 0, duration=0.1))
    assert bool(result.differences) == (engine == "pybullet")
    left = result.all_right if result.differences else result.error
    assert left == pytest.approx(result.step_error, rel=0.2)  # Euler in other coordinates


ARMS = """<mujoco model="arms"><compiler angle="radian"/>
<option timestep="0.01" gravity="0 0 0" {integrator}/><worldbody>{bodies}</worldbody>
<actuator>{actuator}</actuator><keyframe><key qvel="{rates}"/></keyframe></mujoco>"""
ARM = """<body name="{name}" pos="{x} 0 0">
<inertial pos="0.1 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
<joint {joint} axis="0 0 1"/><geom size="0.1" contype="0" conaffinity="0"/></body>"""
STEP, INERTIA = 0.01, 0.11  # [s], [kg m^2] about the hinge
KV = 4.0  # [N m s]


def _on_arms(tmp_path, engine, joints, actuator="", integrator=""):
    """An engine on arms with these joints, which start at 1 rad/s."""
    if not installed(find_engine(engine)):
        pytest.skip(f"{engine} is not installed")
    bodies = [ARM.format(name=f"arm{x}", x=x, joint=joint) for x, joint in enumerate(joints)]
    rates = " ".join("1" for joint in joints for _ in range(3 if "ball" in joint else 1))
    numbers = {"integrator": integrator, "bodies": "".join(bodies), "rates": rates}
    (file := tmp_path / "arms.xml").write_text(
        ARMS.format(actuator=actuator, **numbers), "utf-8"
    )
    return engine_error(engine, held(file, 0, duration=0.1))


@pytest.mark.long
@pytest.mark.parametrize(("integrator", "differs"), [("", True), ('integrator="Euler"', False)])
def test_an_integrator_is_named_where_no_constraint_acts(integrator, differs, tmp_path):
    """If a file names none, Newton's importer takes implicitfast, and MuJoCo Euler. Under a servo's
    damping alone the acceleration in a step of Euler is -kv v / M, and in one of implicitfast
    -kv v / (M + h kv)."""
    servo = f'<velocity name="servo" joint="hinge" kv="{KV}"/>'
    result = _on_arms(tmp_path, "newton", ['name="hinge"'], servo, integrator)
    if not differs:
        assert result.first.term == "single precision"
        return
    assert result.first.term == "integrator"
    # To rounding: both accelerations are MuJoCo's own.
    expected = 1.0 - 1.0 / (1.0 + STEP * KV / INERTIA)
    assert result.first.size == pytest.approx(expected, rel=1e-9)
    assert result.first.cause.startswith("it steps implicitfast, the file euler: 0.27 of")
    assert result.reason == "no force stands for another integrator"


@pytest.mark.parametrize("engine", ["dart", "drake", "pybullet"])
def test_a_ball_joint_is_not_said_to_be_missing(engine, tmp_path):
    result = _on_arms(tmp_path, engine, ['name="ball" type="ball"'])
    assert result.why == "ball joints are not compared"


@pytest.mark.parametrize("engine", ["dart", "drake"])
def test_joints_without_names_are_counted_one_by_one(engine, tmp_path):
    """DART gives the first joint of every tree the same name."""
    result = _on_arms(tmp_path, engine, ["", ""])
    assert result.why == ""
    assert result.error > 0.0


def test_pinocchio_has_the_damping_that_its_reader_keeps(tmp_path):
    """Stepped with it, the error that is left is that of a step of its integrator."""
    result = _on_arms(tmp_path, "pinocchio", ['name="hinge" damping="0.5"'])
    assert result.differences == ()
    assert result.error == pytest.approx(result.step_error, rel=1e-6)
    assert "damping" in _taken_over("pinocchio", tmp_path)[0]


@pytest.mark.parametrize(
    ("actuator", "term", "cause", "read"),
    [
        ('<motor name="servo" joint="hinge" gear="7"/>', "actuator", "gear servo: 1 for 7", ()),
        (
            '<position name="servo" joint="hinge" kp="9" kv="4"/>',
            "actuator",
            "kv servo: 0 for 4",
            ("gear", "kp"),
        ),
        (
            '<position name="servo" joint="hinge" kp="9" dampratio="1"/>',
            "actuator",
            "kv servo: 0 for ",
            ("gear", "kp"),
        ),
        (
            '<position name="servo" joint="hinge" kp="99"/>',
            "acceleration",
            "the gains of its servos act at the end of a step",
            ("gear", "kp"),
        ),
    ],
)
def test_drake_is_said_to_read_what_its_actuators_use(actuator, term, cause, read, tmp_path):
    """In both commands: a gear does not multiply the control of its motors."""
    result = _on_arms(tmp_path, "drake", ['name="hinge"'], actuator)
    taken, dropped = _taken_over("drake", tmp_path)
    assert set(taken) & {"gear", "kp", "kv"} == set(read)
    if term == "actuator":  # a motor whose control is 0 has no force with any gear
        assert cause in [f"{field} {why}"[: len(cause)] for field, why in dropped.items()]
    if "motor" not in actuator:
        assert result.first.term == term
        assert result.first.cause.startswith(cause)


def _taken_over(engine, folder):
    """The fields of the arms that an engine reads, and {field: reason} of those that it drops."""
    reader = compared_reading(engine, *readings_of(find_engine(engine), folder / "arms.xml"))
    return reader.read, reader.dropped or {}
