"""The largest steps of model files in MuJoCo and in engines that build them, against nudged runs
that are made here, and the tangent space of a mechanism against MuJoCo's."""

import json
from functools import partial

import mujoco
import numpy as np
import pytest

from plumbob.engines.abilities import BuildsMechanisms
from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.built_mechanism import BuiltSteppers
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.stability import AuditedMotion, limit_of_method
from plumbob.engines.own_motion import Start
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import method as find_method
from plumbob.engines.step_jacobian import step_jacobian
from plumbob.engines.stepper import State
from plumbob.engines.tangent_space import tangent_space
from plumbob.reports.cli import main
from plumbob.tests.audit.scenes_as_models import compiled

SERVO_ARM = """<mujoco><option timestep="0.001"/><worldbody><body pos="0 0 1">
  <joint name="shoulder" axis="0 1 0" damping="0.5"/>
  <inertial pos="0.05 0 -0.2" mass="1" diaginertia="0.02 0.02 0.005"/>
  <body pos="0 0 -0.4"><joint name="elbow" axis="0 1 0" damping="0.1"/>
    <inertial pos="0.02 0 -0.15" mass="0.5" diaginertia="0.005 0.005 0.001"/></body>
</body></worldbody>
<actuator><position joint="shoulder" kp="400"/><position joint="elbow" kp="900"/></actuator>
<keyframe><key qpos="0.1 0.05"/></keyframe></mujoco>"""
WHEEL = """<mujoco><option timestep="0.005"/><worldbody>
<body><joint name="axle" axis="0 0 1" damping="0.002"/>
<geom type="cylinder" size="0.1 0.01" mass="1"/></body></worldbody>
<actuator><position joint="axle" kp="20" kv="0.1"/></actuator>
<keyframe><key qpos="0.1"/></keyframe></mujoco>"""
# Two rods that stand on their end, held by springs, with dampers.
POLES = """<mujoco><option timestep="0.002"/>
<default><geom type="capsule" size=".02" contype="0" conaffinity="0"/></default>
<worldbody><body><joint axis="0 1 0" stiffness="400" damping="0.2"/>
  <geom fromto="0 0 0 0 0 .4" mass="1"/>
  <body pos="0 0 .4"><joint axis="0 1 0" stiffness="40" damping="0.4"/>
    <geom fromto="0 0 0 0 0 .3" mass=".5"/></body></body></worldbody>
<keyframe><key qpos="0.05 0.1"/></keyframe></mujoco>"""
FILES = {"servo arm": SERVO_ARM, "wheel": WHEEL, "poles": POLES}
BUILT = "pinocchio/aba+euler"
METHODS = ("mujoco/euler", "drake/default", "dart/default", "pybullet/default")
LOST = 1e3  # growth of a nudge, as the README has it, beyond the growth at a fine step
FAR = 1e3  # [rad]: a servo or a spring never lets a joint turn so far
# Of a limit, which is bisected to 2 %: what the README claims. A limit that is 12 % wrong is red.
SIDES = (0.9, 1.1)
STEPS = 400


def course_of(text, name):
    """A file along its motion at fine steps, in the engine of a method."""
    engine = engine_of(find_method(name))
    if not installed(engine):
        pytest.skip("the engine is not installed")
    model = own_model(compiled(text), "file", Start(0))
    motion = script(model, "rest", 0.2)
    states = model.stepped(motion, "rk4", 16 * round(motion.period / model.step)).states
    builds = engine.ability(BuildsMechanisms)
    return AuditedMotion(model, motion, states, builds and BuiltSteppers(builds, model))


def run_in_mujoco(text, step, qpos):
    """Positions after each of STEPS steps of MuJoCo's Euler, shape (STEPS, nq)."""
    model = compiled(text)
    model.opt.timestep = step
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    positions = []
    for _ in range(STEPS):
        mujoco.mj_step(model, data)
        positions.append(data.qpos.copy())
    return np.array(positions)


def run_in_engine(name, text, step, qpos):
    """Positions after each of STEPS steps of an engine that builds the file, shape (STEPS, nq)."""
    model = compiled(text)
    start = State(np.array(qpos), np.zeros(model.nv))
    builds = engine_of(find_method(name)).ability(BuildsMechanisms)
    stepper = builds.build(compiled_mechanism(model), start, step)
    stepper.put(start)
    positions = []
    for _ in range(STEPS):
        stepper.advance(np.zeros((1, model.nu)), 1)
        positions.append(stepper.state().qpos.copy())
    return np.array(positions)


def growth(run, text, step):
    """How many times as large as at the start the distance of two runs becomes; infinite where a
    run is lost."""
    qpos = compiled(text).key_qpos[0]
    nudge = 1e-8 * np.arange(1, qpos.size + 1)
    with np.errstate(all="ignore"):
        try:
            first, second = (run(text, step, start) for start in (qpos, qpos + nudge))
        except RuntimeError:  # Drake's, where its numbers are not finite
            return np.inf
        if not np.isfinite(first).all() or np.abs(first).max() > FAR:
            return np.inf
        return np.abs(first - second).max() / nudge.max()


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("file", FILES)
def test_nudged_runs_hold_below_a_limit_and_are_lost_above(file, name):
    """Where no step up to ten times the file's own is too large, the largest of them holds."""
    text = FILES[file]
    on = course_of(text, name)
    limit = limit_of_method(on, "euler" if name == "mujoco/euler" else name)
    run = run_in_mujoco if name == "mujoco/euler" else partial(run_in_engine, name)
    own = growth(run, text, on.model.step / 4.0)
    assert limit.confirmed
    if limit.largest_step is None:
        assert growth(run, text, 10.0 * on.model.step) < LOST * max(1.0, own)
        return
    below, above = (growth(run, text, side * limit.largest_step) for side in SIDES)
    assert below < LOST * max(1.0, own) < above


FREE_AND_BALL = """<mujoco><option timestep="0.002"/>
<default><geom contype="0" conaffinity="0"/></default>
<worldbody><body pos="0 0 1"><freejoint/><geom type="box" size=".1 .2 .05" mass="2"/>
  <body pos=".2 0 0"><joint type="ball" damping=".1"/>
    <geom type="capsule" fromto="0 0 0 .2 .1 0" size=".03" mass=".5"/>
    <body pos=".2 .1 0"><joint axis="0 1 0" stiffness="2"/><geom pos=".1 0 0" size=".04" mass=".3"/>
</body></body></body></worldbody></mujoco>"""
# Relative to the largest entry: differences of 1e-6 leave 1e-10 of rounding, and 1e-12 by the third
# derivative. An axis that is turned by 1e-6 is 1e-6 away.
SAME = 1e-8


def test_the_derivative_of_a_step_is_mujocos_own():
    """In tangent coordinates of a free body, a ball and a hinge, with MuJoCo's own differences."""
    own = own_model(compiled(FREE_AND_BALL), "file")
    model = own.effective
    space = tangent_space(own.mechanism())
    rng = np.random.default_rng(3)
    data = mujoco.MjData(model)
    mujoco.mj_integratePos(model, data.qpos, rng.normal(size=model.nv), 1.0)
    data.qvel[:] = rng.normal(size=model.nv)
    state = np.concatenate([data.qpos, data.qvel])
    found = step_jacobian(
        own.function_stepper(own.integrator, own.step), space, state, np.zeros(0), 1e-6
    )
    wanted = np.empty((2 * model.nv, 2 * model.nv))
    mujoco.mjd_transitionFD(model, data, 1e-6, 1, wanted, None, None, None)
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=SAME * np.abs(wanted).max())


def test_changes_of_a_state_are_mujocos_own():
    """A change and its size, up to half a turn."""
    model = compiled(FREE_AND_BALL)
    space = tangent_space(compiled_mechanism(model))
    rng = np.random.default_rng(5)
    for size in (1e-9, 1e-3, 1.0, 1.7):
        state = rng.normal(size=model.nq + model.nv)
        mujoco.mj_normalizeQuat(model, state[: model.nq])
        change = size * rng.normal(size=2 * model.nv) / 2.0
        moved = space.shifted(state, change)
        wanted = state[: model.nq].copy()
        mujoco.mj_integratePos(model, wanted, change[: model.nv], 1.0)
        np.testing.assert_allclose(moved[: model.nq], wanted, rtol=0.0, atol=1e-14)
        back = np.zeros(model.nv)
        mujoco.mj_differentiatePos(model, back, 1.0, state[: model.nq], moved[: model.nq])
        changes = space.differences(moved, state)
        np.testing.assert_allclose(changes[: model.nv], back, rtol=0.0, atol=1e-14)
        np.testing.assert_allclose(changes, change, rtol=0.0, atol=1e-14)


def answer(capsys, file, *words, code=0):
    """What `plumbob stability` prints as JSON about a file at its first keyframe."""
    chosen = ["stability", str(file), *words, "--keyframe", "0", "--duration", "0.1"]
    assert main([*chosen, "--budget", "20", "--json"]) == code
    return json.loads(capsys.readouterr().out)


@pytest.mark.long(keep=1)
def test_the_command_answers_for_the_methods_that_are_named(tmp_path, capsys):
    """In their order; the first of them decides whether the file's own step is unstable."""
    if not installed(engine_of(find_method(BUILT))):
        pytest.skip("the engine is not installed")
    (file := tmp_path / "arm.xml").write_text(SERVO_ARM, "utf-8")
    found = answer(capsys, file, BUILT, "mujoco/rk4")
    built, rk4 = found["stability"]
    assert (built["integrator"], rk4["integrator"]) == (BUILT, "rk4")
    assert built["first"].startswith("joint elbow, actuator ")
    assert rk4["largest_step"] > built["largest_step"]
    assert "armature" in found["remedies"][0]["change"]
    assert {"mujoco", "pinocchio"} <= set(found["versions"])
    file.write_text(SERVO_ARM.replace('timestep="0.001"', 'timestep="0.006"'), "utf-8")
    assert answer(capsys, file, BUILT, code=1)["unstable"]


TENDON = '<tendon><fixed name="strap"><joint joint="elbow" coef="1"/></fixed></tendon></mujoco>'


@pytest.mark.long(keep=1)
def test_a_part_that_an_engine_does_not_express_is_named(tmp_path, capsys):
    if not installed(engine_of(find_method(BUILT))):
        pytest.skip("the engine is not installed")
    (file := tmp_path / "arm.xml").write_text(
        SERVO_ARM.replace("</mujoco>", TENDON.replace("<fixed", '<fixed stiffness="1"')),
        "utf-8",
    )
    (limit,) = answer(capsys, file, BUILT, code=3)["stability"]
    assert (limit["confirmed"], limit["largest_step"]) == (False, None)
    assert "tendon strap" in limit["why"]
