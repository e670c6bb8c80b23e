"""`plumbob plan --method`: the errors of a plan run in an engine, by kind of manoeuvre."""

import json

import pytest

from plumbob.engines.registry import method
from plumbob.models.registry import scene
from plumbob.models.tripod_capsule.plan import requested_plan
from plumbob.reports.analyses.capsule_plan.pose_errors import (
    POSE_OBSERVABLES,
    error_by_name,
    errors_by_kind,
)
from plumbob.reports.cli import main
from plumbob.reports.commands.plan import run_plan

TO = (0.02, 0.0, 0.05)  # a turn and a line or two
FEET = method("pymunk/feet")


@pytest.mark.long
def test_the_errors_of_all_manoeuvres_add_up_to_the_error_at_the_end():
    short = scene("capsule-plan", {"to": TO})
    found = requested_plan(short.parameters)
    run = run_plan(found, short, FEET, 2e-4)
    assert {"turn", "line", "slow"} <= (kinds := {m.kind for m in found.manoeuvres})
    last = run.errors_after[-1]
    parts = errors_by_kind(found, run.errors_after)
    # a sum of some ten roundings of 1e-4
    assert sum(parts.values()) == pytest.approx(last, abs=1e-15)
    ends = [run.measurement.errors[name].end for name in POSE_OBSERVABLES]
    assert ends == pytest.approx(last, abs=1e-13)
    assert set(parts) <= kinds
    # While the body sticks, the only error is the residual of the solver's iterations.
    assert error_by_name(parts["slow"])["distance"] < 1e-3 * error_by_name(last)["distance"]
    assert abs(last[2]) < 1e-3


@pytest.mark.long
def test_the_command_says_where_errors_arise(capsys):
    words = ["plan", "--to", *(str(value) for value in TO), "--method", "pymunk/feet"]
    assert main([*words, "--step", "1e-3"]) == 0
    out = capsys.readouterr().out
    assert " moving " in out  # at the end of a turn, before the residual motion
    assert "Part of the error that arises in turns: " in out
    assert main([*words, "--step", "1e-3", "--json"]) == 0
    run = json.loads(capsys.readouterr().out)["method"]
    assert run["status"] == "done"
    assert run["off_after"][-1]["heading"] == pytest.approx(run["errors_at_end"]["heading"])
    assert set(run["arising"]) >= {"turn", "line"}


@pytest.mark.long
def test_a_method_that_cannot_run_a_plan_says_why(capsys):
    words = ["plan", "--to", *(str(value) for value in TO), "--step", "1e-3"]
    assert main([*words, "--method", "pymunk/side"]) == 0
    assert "pymunk/side with a step of 0.001 s: unsupported: " in capsys.readouterr().out
