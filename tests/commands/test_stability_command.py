"""`plumbob stability`: records, a table, a page, exit codes, and one line for what it cannot do."""

import json

import pytest

from plumbob.engines.adapters import integrators
from plumbob.reports.cli import main

OVERDAMPED = "linear-pendulum/overdamped"
KEYS = {"scene", "method", "kind", "predicted", "holds", "fails", "why"}


def test_json_stands_alone_with_a_record_a_limit(capsys):
    assert main(["stability", OVERDAMPED, "ode/euler", "ode/radau", "--json"]) == 0
    euler, radau = json.loads(capsys.readouterr().out)
    assert set(euler) >= KEYS
    assert (euler["kind"], euler["verdict"]) == ("unstable", "predicted")
    assert euler["holds"] < euler["fails"] <= 1.011 * euler["holds"]
    assert euler["predicted"] == pytest.approx(euler["holds"], rel=0.02)
    assert [radau[name] for name in ("kind", "predicted", "holds", "fails")] == [None] * 4
    assert "chooses its steps" in radau["why"]


def test_a_sabotaged_engine_is_exit_code_1(capsys, monkeypatch):
    monkeypatch.setattr(integrators, "semi_implicit_euler", integrators.rk4)
    assert main(["stability", OVERDAMPED, "ode/euler"]) == 1
    assert (
        f"UNEXPECTED {OVERDAMPED} ode/euler: 1.7 of the predicted step"
        in capsys.readouterr().out
    )


@pytest.mark.long
def test_long_runs_have_a_record_a_table_and_a_page(tmp_path, capsys):
    given = ["stability", "simple-pendulum/damped-large", "ode/*", "--long", "--step", "0.02"]
    chosen = [*given[:2], "ode/leapfrog", "ode/rk4", *given[3:]]
    assert main([*chosen, "--json"]) == 0
    records = json.loads(capsys.readouterr().out)
    assert [record["growth"] for record in records] == ["decaying"] * 2
    assert [level["error"] for level in records[0]["times"]] == [0.01, 0.1, 1.0]
    assert main([*chosen, "--out", str(tmp_path)]) == 0
    assert "decaying" in capsys.readouterr().out
    assert "How long does a method stay right?" in (tmp_path / "stability.html").read_text(
        "utf-8"
    )
    assert main([*chosen[:-3], "--step", "0.02"]) == 2
