"""A policy of one's own: recorded at the model's own step, and replayed."""

import mujoco
import numpy as np
import pytest

from plumbob import audit
from plumbob.reports.cli import main

ROD = """<mujoco><option timestep="0.005"/><worldbody><body><joint name="hinge" axis="0 1 0"/>
<geom size=".1" pos=".5 0 0"/></body></worldbody>
<actuator><motor joint="hinge"/></actuator></mujoco>"""


def holding(time, qpos, qvel):
    return np.asarray(-20.0 * qpos - 2.0 * qvel + np.sin(3.0 * time))


@pytest.mark.long
@pytest.mark.parametrize("held", [1, 4])
def test_what_is_replayed_is_the_users_own_loop_to_the_bit(held):
    model = mujoco.MjModel.from_xml_string(ROD)
    data = mujoco.MjData(model)
    controls = []
    for _ in range(40 // held):
        data.ctrl[:] = holding(data.time, data.qpos, data.qvel)
        controls.append(data.ctrl.copy())
        mujoco.mj_step(model, data, held)
    period = None if held == 1 else held * 0.005
    found = audit(model, policy=holding, period=period, duration=0.2, budget=5.0)
    np.testing.assert_array_equal(found.script.controls, controls)
    assert found.script.period == pytest.approx(held * 0.005)
    assert found.control.startswith("policy, recorded")
    assert found.until == pytest.approx(0.2)
    assert found.error > 1e-5  # of the step, which is resolved


def test_on_the_command_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rod.xml").write_text(ROD)
    (tmp_path / "holding_rod.py").write_text(
        "def act(time, qpos, qvel):\n    return -qpos\ndef leaves(*state):\n    raise SystemExit\n"
    )
    line = ["audit", "rod.xml", "--duration", "0.05", "--budget", "1"]
    assert main([*line, "--policy", "holding_rod:act"]) == 0
    assert (
        "control (policy, recorded at the model's own step) held 5 ms"
        in capsys.readouterr().out
    )
    for wrong in (
        "holding_rod",
        "holding_rod:none",
        "no_such_module:act",
        "holding_rod:__name__",
        "holding_rod:leaves",
    ):
        assert main([*line, "--policy", wrong]) == 2
        err = capsys.readouterr().err
        assert (err.count("\n"), "policy = " in err) == (1, True)
    assert main([*line, "--policy", "holding_rod:act", "--ctrl", "sines"]) == 2
