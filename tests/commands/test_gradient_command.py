"""`plumbob gradient`: records, a table, exit codes."""

import json

import pytest

from plumbob.engines.adapters import integrators
from plumbob.reports.cli import main

CONE = "cone-pendulum/rotating-base"
KEYS = {"of", "by", "way", "exact", "computed", "relative_error", "predicted_error", "eps"}


def test_a_sabotaged_engine_is_exit_code_1(capsys, monkeypatch):
    monkeypatch.setattr(integrators, "semi_implicit_euler", integrators.rk4)
    given = ["--by", "gravity", "--of", "theta", "--way", "central", "--eps", "1e-3"]
    assert main(["gradient", CONE, "ode/euler", *given]) == 1
    assert f"UNEXPECTED {CONE} ode/euler: central, theta by gravity" in capsys.readouterr().out


@pytest.mark.long
def test_several_steps_show_the_order_of_several_methods(capsys):
    words = ["--of", "theta_dot,theta", "--by", "theta", "--step", "4e-3,2e-3", "--eps", "1e-3"]
    words += ["--way", "central", "--json"]
    assert main(["gradient", CONE, "mujoco/euler", "ode/rk4", *words]) == 0
    records = json.loads(capsys.readouterr().out)
    assert all(set(record) >= KEYS for record in records)
    assert {record["verdict"] for record in records} == {"predicted"}
    assert [record["step"] for record in records] == [4e-3, 4e-3, 2e-3, 2e-3] * 2
    orders = {record["method"]: record["order"] for record in records}  # of the angle, the last
    assert 0.9 < orders["mujoco/euler"] < 1.2
    assert 3.9 < orders["ode/rk4"] < 4.9
