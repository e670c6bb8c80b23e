"""`--like` on the command line: the error of a user's settings, and better methods."""

from dataclasses import replace

import pytest

from plumbob.engines.study.measurement import measure, relative_error
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.cli import main
from plumbob.reports.commands.arguments.like import own_method
from plumbob.reports.records import notation
from plumbob.tests.commands.outcomes import without_findings

PENDULUM, LINE = "cone-pendulum/rotating-base", "capsule-line/heading-030"
METHODS = "mujoco/euler+coulomb,ode/rk4"
VALIDATE = ("validate", "--scenes", f"{PENDULUM},{LINE}", "--methods", METHODS)
STEP = 0.002


def written(folder, integrator):
    """A model file with this integrator and the step that MuJoCo takes by default."""
    path = folder / "my.xml"
    path.write_text(
        f'<mujoco><option integrator="{integrator}" timestep="{STEP}"/></mujoco>', "utf-8"
    )
    return str(path)


@pytest.mark.long
def test_validate_reports_the_error_and_better_methods(tmp_path, capsys, monkeypatch):
    without_findings(monkeypatch)
    like = written(tmp_path, "Euler")
    out = str(tmp_path / "out")
    assert main([*VALIDATE, "--like", like, "--out", out, "--jobs", "1"]) == 0
    answer = capsys.readouterr().out
    page = (tmp_path / "out" / "index.html").read_text("utf-8")
    assert "How large are the errors of your settings?" in page
    assert "at no greater cost, most accurate in MuJoCo" in page
    cone = _section(answer, PENDULUM)
    line = _section(answer, LINE)
    assert f"error              {notation.number(_error(PENDULUM, like))} rad" in cone
    assert f"error              {notation.number(_error(LINE, like))} m" in line
    # default contacts do not converge, which is reported, and is no failure
    assert "not-converging" in line
    assert "at equal accuracy  mujoco/euler+coulomb" in line
    assert "at equal accuracy  ode/rk4" in cone
    assert "at no greater cost " in cone  # what, depends on costs: see test_user_settings.py


def _section(text, scene):
    """What is said of the user's settings on one scene."""
    return text.rpartition(f"\n{scene}: ")[2].partition("\n\n")[0]


def _error(name, like):
    scene = find_scene(name)
    case = case_of(scene)
    run, _ = measure(case, own_method(like), STEP)
    first = case.system.quantities(case)[0]
    return relative_error(run, (replace(first, scale=1.0),))
