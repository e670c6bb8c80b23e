"""`plumbob check-engine`: what an adapter promises is seen, and each small defect turns its check
red."""

import json
import os

import pytest

from plumbob.models import entry_points
from plumbob.reports.cli import main
from plumbob.reports.judge.engine_check import CHECKS
from plumbob.tests.outside.installed_packages import (
    DEFECTS,
    ENGINE,
    changed,
    install,
    install_folder,
    seen,
)

RETURN = "return stepped(case, step, build)"
WRAPPED = """
from dataclasses import dataclass, replace
from plumbob.engines.method import Stepping

@dataclass
class Wrapped:
    inner: object
    compile_seconds: float = 0.0

    def run(self):
        run = self.inner.run()
        return {run}

    def stepped(self, fraction):
        return {stepped}
"""


CASES = DEFECTS["checks"]


def with_defect(defect):
    """The engine with a piece of its text replaced, or with simulations that return another
    thing."""
    text = ENGINE.replace("Scheme(EULER)", defect.get("scheme", "Scheme(EULER)"))
    if "right" in defect:
        return changed(text, defect["right"], defect["wrong"])
    text = changed(text, RETURN, "return Wrapped(stepped(case, step, build))")
    stepped = defect.get("stepped", "self.inner.stepped(fraction)")
    return text + WRAPPED.format(run=defect.get("run", "run"), stepped=stepped)


def outcome(site, text, capsys):
    """Exit code and checks of an engine with this text."""
    install(site, "theirs", {entry_points.ENGINE_GROUP: {"tiny": "theirs:ENGINE"}}, theirs=text)
    with seen(site):
        code = main(
            ["check-engine", "tiny", "--scenes", "simple-pendulum/free-large", "--json"]
        )
    return code, {check["name"]: check for check in json.loads(capsys.readouterr().out)}


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("kind", CASES)
def test_a_defect_turns_its_check_red(kind, tmp_path, capsys):
    defect = CASES[kind]
    code, found = outcome(tmp_path, with_defect(defect), capsys)
    assert code == 1
    assert found[defect["check"]]["status"] == "fail"
    assert defect["why"] in found[defect["check"]]["detail"]


def test_the_example_passes_with_a_line_a_check(tmp_path, capsys, monkeypatch):
    install_folder(tmp_path / "site", "tiny_engine")
    monkeypatch.chdir(tmp_path)
    with seen(tmp_path / "site"):
        assert main(["check-engine", "tiny"]) == 0
    out, err = capsys.readouterr()
    lines = out.splitlines()
    assert [line[:4] for line in lines] == ["pass"] * len(CHECKS)
    assert [name in line for name, line in zip(CHECKS, lines, strict=True)] == [True] * len(
        lines
    )
    assert err == ""
    assert os.listdir(tmp_path) == ["site"]


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("name", ["ode/leapfrog", "ode/dop853", "mujoco/euler", "pymunk/tight"])
def test_engines_of_ours_pass(name, capsys):
    assert main(["check-engine", name, "--scenes", "*/free-small"]) == 0
    assert "fail" not in capsys.readouterr().out
