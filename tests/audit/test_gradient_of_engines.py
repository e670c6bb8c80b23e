"""Derivatives of runs of model files in engines that build them, held against central differences
that are taken here: nothing of the product but the stepper is used for these."""

from itertools import product

import mujoco
import numpy as np
import pytest

from plumbob.engines.abilities import BuildsMechanisms
from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.gradient import derivatives_of_run, numbers_of
from plumbob.engines.registry import find_engine, installed
from plumbob.engines.registry import method as find_method
from plumbob.engines.stepper import State

STEP = 2e-3  # [s]
PERIODS, PARTS = 2, 10  # of a control, and its steps
ARM = """<mujoco><option timestep="0.002"/><worldbody><body name="upper" pos="0 0 1">
  <joint name="shoulder" axis="0 1 0" damping="0.3"/>
  <inertial pos="0.05 0 -0.2" mass="1" diaginertia="0.02 0.02 0.005"/>
  <body name="lower" pos="0 0 -0.4"><joint name="elbow" axis="0.6 0.8 0" stiffness="2"/>
    <inertial pos="0.02 0 -0.15" mass="0.5" fullinertia="0.03 0.03 0.03 0.002 0.006 0.003"/></body>
</body></worldbody>
<actuator><motor name="motor" joint="shoulder" gear="3"/></actuator></mujoco>"""
CART = """<mujoco><option timestep="0.002"/><worldbody><body name="cart">
  <joint name="rail" type="slide" axis="1 0 0" damping="2"/>
  <inertial pos="0 0 0" mass="2" diaginertia="0.01 0.01 0.01"/>
  <body name="pole"><joint name="pin" axis="0 1 0" armature="0.01"/>
    <inertial pos="0 0 0.5" mass="0.4" diaginertia="0.01 0.01 0.001"/></body>
</body></worldbody>
<actuator><position name="servo" joint="rail" kp="80" kv="5"/></actuator></mujoco>"""
TURNING = """<mujoco><option timestep="0.002"/><worldbody>
<body name="hung" pos="0 0 1"><joint name="ball" type="ball"/>
  <inertial pos="0.1 0.05 -0.3" mass="1" diaginertia="0.03 0.02 0.01"/></body>
<body name="loose" pos="1 0 1"><freejoint name="loose"/>
  <inertial pos="0.02 0 0.01" mass="0.4" diaginertia="0.003 0.002 0.004"/></body>
</worldbody></mujoco>"""
FILES = {"arm": ARM, "cart": CART, "turning": TURNING}
METHODS = (
    *("mujoco/euler", "mujoco/rk4", "drake/default", "dart/default", "pybullet/default"),
    "pinocchio/aba+euler",
)
QUICK = (("pinocchio/aba+euler", "turning"), ("drake/default", "arm"), ("mujoco/euler", "cart"))
EVERY = (*QUICK, *(pair for pair in product(METHODS, FILES) if pair not in QUICK))
EPS = 1e-4
# Relative to the largest derivative. Differences by EPS and by the sweep's own eps leave 1e-8 of
# it, forward differences 1e-7, and rounding 1e-9. A gear that is 1e-4 wrong makes 2e-6 of it.
APART = 1e-6
START = 0.7  # [rad/s, m/s] of each velocity, so that bodies turn


def start_of(model):
    """A state in which all moves, as MuJoCo's data."""
    data = mujoco.MjData(model)
    mujoco.mj_integratePos(model, data.qpos, np.linspace(0.3, 0.5, model.nv), 1.0)
    data.qvel[:] = START
    return data


def end_of(model, method, qpos, qvel, controls):
    """The positions after a run under `controls`, a row for a step, by the engine of a method."""
    if method.startswith("mujoco/"):
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = qpos, qvel
        for row in controls:
            data.ctrl[:] = row
            mujoco.mj_step(model, data)
        return data.qpos.copy()
    builds = find_engine(method.partition("/")[0]).ability(BuildsMechanisms)
    stepper = builds.build(compiled_mechanism(model), State(qpos, qvel), STEP)
    stepper.put(State(qpos, qvel))
    for row in controls:
        stepper.advance(row[None], 1)
    return stepper.state().qpos


def central_differences(model, method, controls):
    """Derivatives of the end by positions, velocities and constant additions to controls, shape
    (nv, 2 nv + nu)."""
    columns = []
    for number in range(2 * model.nv + model.nu):
        ends = []
        for side in (EPS, -EPS):
            data = start_of(model)
            shift = side * (np.arange(2 * model.nv + model.nu) == number)
            by_place, by_rate, by_control = np.split(shift, [model.nv, 2 * model.nv])
            mujoco.mj_integratePos(model, data.qpos, by_place, 1.0)
            ends.append(
                end_of(model, method, data.qpos, data.qvel + by_rate, controls + by_control)
            )
        change = np.zeros(model.nv)
        mujoco.mj_differentiatePos(model, change, 2.0 * EPS, ends[1], ends[0])
        columns.append(change)
    return np.transpose(columns)


def ways_of(name, text):
    """The derivatives of the product's run of a file by each way, with central differences of runs
    that are taken here."""
    model = mujoco.MjModel.from_xml_string(text)
    if name == "mujoco/rk4":
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    start = start_of(model)
    own = own_model(model, "model")
    own.start.qpos[:], own.start.qvel[:] = start.qpos, start.qvel
    motion = script(own, "sines", PERIODS * PARTS * STEP)
    known = np.ones(len(numbers_of(own)), bool)
    ways = derivatives_of_run(find_method(name), own, motion, known, 600.0)
    controls = np.repeat(motion.controls, PARTS, axis=0)
    return ways, central_differences(model, name, controls)


@pytest.mark.long(keep=len(QUICK))
@pytest.mark.parametrize(("name", "file"), EVERY)
def test_each_way_gives_central_differences_of_the_engines_runs(name, file):
    if not installed(find_engine(name.partition("/")[0])):
        pytest.skip("the engine is not installed")
    ways, wanted = ways_of(name, FILES[file])
    assert len(ways) >= 3
    for way in ways:
        if way.computed is None:
            refusals = "refuses RK4", "need a tree of hinges and slides"
            assert any(words in way.why for words in refusals), way.why
            continue
        there = np.isfinite(way.computed[-1])
        assert there.all() == (not way.why)
        difference = np.abs(way.computed[-1] - wanted)[there].max()
        assert difference < APART * np.abs(wanted).max(), way.name


def test_a_wrong_gear_shows_in_each_way():
    """The bound of the test above is not too wide."""
    ways, _ = ways_of("mujoco/euler", ARM.replace('gear="3"', 'gear="3.0003"'))
    _, wanted = ways_of("mujoco/euler", ARM)
    for way in ways:
        assert np.abs(way.computed[-1] - wanted).max() > APART * np.abs(wanted).max()
