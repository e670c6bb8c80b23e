"""`plumbob gradient`: records, a table, exit codes."""

import json

import pytest

from plumbob.engines.adapters import integrators
from plumbob.reports.cli import main

CONE = "cone-pendulum/rotating-base"
KEYS = {"of", "by", "way", "exact", "computed", "relative_error", "predicted_error", "eps"}


@pytest.mark.long
def test_json_has_a_record_for_each_way_and_parameter(capsys):
    given = ["--of", "theta,theta_dot", "--by", "gravity,theta", "--eps", "1e-3", "--json"]
    assert main(["gradient", CONE, "ode/rk4", "--way", "central", *given]) == 0
    records = json.loads(capsys.readouterr().out)
    assert len(records) == 4
    assert all(set(record) >= KEYS for record in records)
    assert {record["verdict"] for record in records} == {"predicted"}


def test_a_sabotaged_engine_is_exit_code_1(capsys, monkeypatch):
    monkeypatch.setattr(integrators, "semi_implicit_euler", integrators.rk4)
    given = ["--by", "gravity", "--of", "theta", "--way", "central", "--eps", "1e-3"]
    assert main(["gradient", CONE, "ode/euler", *given]) == 1
    assert f"UNEXPECTED {CONE} ode/euler: central, theta by gravity" in capsys.readouterr().out


@pytest.mark.long
def test_several_steps_show_the_order_of_several_methods(capsys):
    words = ["--of", "theta", "--by", "theta", "--step", "4e-3,2e-3", "--eps", "1e-3", "--json"]
    assert main(["gradient", CONE, "mujoco/euler", "ode/rk4", "--way", "central", *words]) == 0
    records = json.loads(capsys.readouterr().out)
    orders = {record["method"]: record["order"] for record in records}
    assert [record["step"] for record in records] == [4e-3, 2e-3] * 2
    assert 0.9 < orders["mujoco/euler"] < 1.2
    assert 3.9 < orders["ode/rk4"] < 4.9
