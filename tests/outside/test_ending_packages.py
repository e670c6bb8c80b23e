"""Packages that end the process when their engine runs."""

import subprocess
import sys

import pytest

from plumbob.reports.cli import main
from plumbob.tests.commands.outcomes import validated, without_pages
from plumbob.tests.outside.installed_packages import ENGINE, broken, seen

SWING = "simple-pendulum/free-large"


@pytest.fixture
def site(tmp_path):
    """A folder that packages are installed in."""
    return tmp_path / "site"


PLACES = {
    "prepare": ("return stepped(case, step, build)", "    "),
    "run": ("return Built(advance, lambda", "        "),
}
WITHOUT_PAGES = """
import sys
from pytest import MonkeyPatch
from plumbob.reports.cli import main
from plumbob.tests.commands.outcomes import without_pages
without_pages(MonkeyPatch())
if __name__ == "__main__":
    sys.exit(main())
"""


@pytest.fixture(params=PLACES)
def ending(request, site, monkeypatch):
    """Installs an engine with a statement in one of its functions."""
    line, indent = PLACES[request.param]

    def installed(statement):
        broken(site, ENGINE.replace(line, f"{statement}\n{indent}{line}"))
        monkeypatch.setenv("PYTHONPATH", str(site), prepend=":")  # of the process that runs it

    return installed


@pytest.mark.long
def test_an_engine_that_exits_is_a_verdict(ending, site, tmp_path, monkeypatch, capsys):
    ending("raise SystemExit(0)")
    without_pages(monkeypatch)
    with seen(site):
        found = validated(tmp_path, capsys, SWING, "tiny,ode/euler")
        assert main(["run", SWING, "tiny/euler", "--step", "1e-2"]) == 1
    assert found.code == 1
    assert "raises SystemExit: 0" in found.failure(SWING, "tiny/euler")
    assert found.failure(SWING, "ode/euler") == ""


@pytest.mark.long
def test_an_engine_that_ends_the_process_costs_its_runs(ending, site):
    ending("__import__('os')._exit(0)")
    study = ["validate", "--scenes", SWING, "--methods", "tiny", "--jobs", "1"]
    for words in (["run", SWING, "tiny/euler", "--step", "1e-2"], [*study, "--out", str(site)]):
        command = [sys.executable, "-c", WITHOUT_PAGES, *words]
        ran = subprocess.run(command, check=False, capture_output=True, text=True)
        assert ran.returncode in (1, 3)
        assert "missing" in ran.stdout
        assert "Traceback" not in ran.stdout + ran.stderr
