"""MuJoCo runs: samples, divergence, the engine's own messages, controls held over steps."""

import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest

from plumbob.engines import sampling
from plumbob.engines.adapters.mujoco import ENGINE, prepare
from plumbob.engines.adapters.mujoco.simulation import MujocoSimulation
from plumbob.engines.adapters.mujoco.translation import Translation
from plumbob.tests.mujoco.one_hinge import HINGE
from plumbob.tests.support.cone_scene import SYSTEM, scene

# nothing is controlled here: the methods that differ in a control are left out
METHODS = {
    m.name: m
    for m in ENGINE.methods
    if not {"control_at", "contact", "model"} & m.settings.keys()
}
EULER = METHODS["mujoco/euler"]

PUSHED = """
<mujoco>
  <option timestep="1e-3"/>
  <worldbody>
    <geom type="plane" size="5 5 .1"/>
    <body pos="0 0 .1">
      <freejoint/>
      <geom type="box" size=".1 .1 .1"/>
      <body pos="0 0 .2">
        <joint name="slide" type="slide" axis="1 0 0"/>
        <geom type="box" size=".05 .05 .05"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="slide"/></actuator>
</mujoco>
"""


def simulation(xml, translation, steps):
    """Any model as the adapter would run it, with its first coordinate and rate observed."""
    model = mujoco.MjModel.from_xml_string(xml)
    given = {
        "spec": None,
        "qpos": np.array(model.qpos0),
        "qvel": np.zeros(model.nv),
        "observe": lambda qpos, qvel: ({"q": qpos[:, 0], "v": qvel[:, 0]}, {}),
    }
    whole = Translation(**{**given, **translation})
    return MujocoSimulation(whole, model, steps, model.opt.timestep)


def test_samples_end_with_the_run_and_times_are_multiples_of_the_step():
    # 0.5 s is 714.3 steps of 7e-4 s: the run ends at the step nearest to it
    trajectory = prepare(SYSTEM.case(scene()), EULER, 7e-4).run()
    assert trajectory.steps == 714
    assert trajectory.times[0] == 0.0
    assert trajectory.times[-1] == 714 * 7e-4
    assert len(trajectory.times) <= sampling.MAX_SAMPLES + 1
    np.testing.assert_array_equal(np.diff(trajectory.times)[:-1] > 0.9 * 2 * 7e-4, True)


@pytest.mark.parametrize("method", METHODS.values(), ids=lambda method: method.name)
def test_a_step_far_too_large_is_a_divergence(method):
    # the torque is bounded, so a step of half a turn exceeds any speed the body can have
    trajectory = prepare(SYSTEM.case(scene(duration=200.0)), method, 0.5).run()
    assert 0.0 < trajectory.diverged_at < 200.0
    assert (trajectory.times < trajectory.diverged_at).all()
    for values in (*trajectory.observables.values(), *trajectory.channels.values()):
        assert len(values) == len(trajectory.times)
        assert np.isfinite(values).all()


def test_the_engines_own_alarm_ends_the_run(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    spring = HINGE.format(joint='stiffness="-1e6"', contype=0, more="")
    # qpos grows as e^{at}, past the engine's 1e10 long before 5000 steps of 2 ms
    trajectory = simulation(spring, {"qpos": np.array([1e-3])}, 5000).run()
    assert trajectory.diverged_at == 0.06
    assert np.abs(trajectory.observables["q"]).max() < 1e10
    assert len(trajectory.times) > 1
    assert any("unstable" in message for message in trajectory.warnings)
    assert not list(tmp_path.iterdir())
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("control_at", [0.0, 0.5])
def test_controls_are_held_over_each_step(control_at):
    # with contacts, so that the solver has its warm start
    def control(times):
        return 20 * np.sin(40 * times)[:, None]

    given = {"control": control, "control_at": control_at}
    simulated = simulation(PUSHED, given, 1000)
    trajectory = simulated.run()
    data = mujoco.MjData(simulated.model)
    for n in range(1000):
        data.ctrl[:] = control(np.array([(n + control_at) * 1e-3]))[0]
        mujoco.mj_step(simulated.model, data)
    assert data.ncon > 0
    assert abs(data.qpos[0]) > 1e-4
    assert trajectory.observables["q"][-1] == data.qpos[0]


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(
    "code",
    [
        "import plumbob.engines.adapters.mujoco, plumbob.engines.adapters.ode",
        "from plumbob.engines.registry import method; from plumbob.models.registry import case_of, "
        "scene; from plumbob.engines.adapters.mujoco.contacts import soft_contact; "
        "problem = case_of(scene('capsule-line/ca1')).problem; "
        "assert soft_contact(problem, method('mujoco/euler+coulomb').settings, 1e-3)",
    ],
)
def test_adapters_are_imported_without_their_engines(code):
    code += "; import sys; print({'mujoco', 'pymunk', 'scipy.integrate'} & set(sys.modules))"
    root = Path(__file__).parents[2]
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=root, check=True, capture_output=True, text=True)
    assert done.stdout.strip() == "set()"


@pytest.mark.long
@pytest.mark.parametrize("chosen", ["", "glfw"])
def test_a_command_begins_no_process_that_looks_for_windows(chosen, monkeypatch):
    """Unless the user's environment names a library for them."""
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    if chosen:
        monkeypatch.setenv("MUJOCO_GL", chosen)
    code = "import sys; from plumbob.__main__ import main; code = main(); "
    code += "print(code, 'mujoco' in sys.modules, 'glfw' in sys.modules)"
    words = ["run", "linear-pendulum/overdamped", "mujoco/euler", "--step", "0.01"]
    done = subprocess.run(
        [sys.executable, "-c", code, *words], check=True, capture_output=True, text=True
    )
    assert done.stdout.splitlines()[-1] == f"0 True {bool(chosen)}"
