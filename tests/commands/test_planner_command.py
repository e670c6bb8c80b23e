"""`plumbob plan`: what it prints, and what it says of a pose that can't be reached."""

import json

import pytest

from plumbob.reports.cli import main


@pytest.mark.long
def test_the_command_prints_manoeuvres_time_and_errors(capsys):
    words = ["plan", "--to", "0.05", "-1e-2", "0", "--track", "curve", "--set", "stroke=0.1"]
    assert main(words) == 0
    out = capsys.readouterr().out
    assert out.startswith("Plan to x = 0.05 m, y = -0.01 m, heading 0 rad: ")
    curve = "on one curve: the line C-A1, the shorter arc, the line C-A2."
    assert f"The slider moves {curve}\n" in out
    assert "  line  w1 " in out
    assert "\nThe exact motion ends " in out
    assert main([*words, "--json", "--set", "start=[0.04, 0, 0.3]"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["turns"] > 0  # from heading 0.3 to 0
    assert answer["limits"]["stroke"] == 0.1
    last = answer["manoeuvres"][-1]
    assert answer["total_time"] == pytest.approx(last["start"] + last["duration"])
    assert max(answer["position_error"], answer["heading_error"]) <= 1e-9


def test_a_plan_for_an_engine_that_is_missing_is_exit_code_3(monkeypatch, capsys):
    monkeypatch.setattr("plumbob.engines.study.measurement.installed", lambda engine: False)
    words = [
        "plan",
        "--to",
        "0.05",
        "0",
        "0",
        "--method",
        "mujoco/rk4+coulomb",
        "--step",
        "1e-3",
    ]
    assert main(words) == 3
    lines = capsys.readouterr().out.splitlines()
    assert lines[-1].startswith("mujoco/rk4+coulomb with a step of 0.001 s: missing")
