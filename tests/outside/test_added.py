"""An engine and a system of other packages take part in everything; what is broken costs a line."""

import json

import pytest

from plumbob.models import entry_points
from plumbob.reports.cli import main
from plumbob.tests.commands.outcomes import validated, without_findings, without_pages
from plumbob.tests.outside.installed_packages import (
    DEFECTS,
    ENGINE,
    PACKAGES,
    broken,
    changed,
    install_folder,
    seen,
)

SYSTEM = (PACKAGES / "falling_body" / "falling_body.py").read_text("utf-8")
SWING, FALL = "simple-pendulum/free-large", "falling-body/from-rest"


@pytest.fixture
def site(tmp_path):
    """A folder that packages are installed in."""
    return tmp_path / "site"


@pytest.fixture
def both(site):
    """The example packages, installed."""
    install_folder(site, "tiny_engine")
    install_folder(site, "falling_body")
    with seen(site):
        yield site


@pytest.mark.long
def test_both_are_measured_judged_and_recommended(both, tmp_path, monkeypatch, capsys):
    """With worker processes, which find the packages by themselves, and a page."""
    monkeypatch.setenv("PYTHONPATH", str(both), prepend=":")
    monkeypatch.chdir(tmp_path)
    without_findings(monkeypatch)
    junit = tmp_path / "j.xml"
    chosen = f"{FALL},simple-pendulum/free-small"
    words = ["validate", "--scenes", chosen, "--methods", "tiny,ode/euler", "--jobs", "2"]
    assert main([*words, "--json", "--junitxml", str(junit)]) == 0
    found = {(r["scene"], r["method"]): r for r in json.loads(capsys.readouterr().out)}
    assert set(found) == {
        (FALL, "ode/euler"),
        ("simple-pendulum/free-small", "ode/euler"),
        ("simple-pendulum/free-small", "tiny/euler"),
    }
    assert 'name="tiny/euler"' in junit.read_text("utf-8")
    pages = "".join(p.read_text("utf-8") for p in (tmp_path / "plumbob-out").rglob("*.html"))
    assert "tiny/euler" in pages
    assert "Falling body with drag" in pages
    assert "tiny-engine" in pages  # its version, among the others
    assert main(["recommend", "falling-body", "--error", "1e-2", "--stored"]) == 0
    assert "ode/euler" in capsys.readouterr().out
    assert main(["recommend", "simple-pendulum/free-small", "--error", "0.1", "--stored"]) == 0
    assert "tiny/euler" in capsys.readouterr().out


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("pendulum.gravity /", "1.01 * pendulum.gravity /"),
        ("state[0] += step", "state[0] += 1.001 * step"),
        ("state = [pendulum.theta,", "state = [1.0001 * pendulum.theta,"),
    ],
)
def test_a_defect_of_an_added_engine_is_a_failure(right, wrong, site):
    from plumbob import check

    assert right in ENGINE
    broken(site, ENGINE.replace(right, wrong))
    with (
        seen(site),
        pytest.raises(
            AssertionError, match=r"(off-prediction|not-converging), expected predicted"
        ),
    ):
        check(SWING, "tiny/euler")


OFF = ENGINE.replace("pendulum.gravity /", "1.01 * pendulum.gravity /").replace(
    "import Engine, Method", "import Engine, KnownLimit, Method"
)


def limited(limit):
    """An engine with a defect, whose package declares known limits."""
    return OFF.replace("    not_read=", f"    known_limits=({limit},),\n    not_read=")


@pytest.mark.long(keep=4)
@pytest.mark.parametrize("kind", DEFECTS["engines"])
def test_a_broken_engine_costs_a_line(kind, site, capfd):
    """The rest is listed; whoever asks for it is informed why not, with exit code 2."""
    defect = DEFECTS["engines"][kind]
    if "right" in defect:
        text = changed(ENGINE, defect["right"], defect["wrong"])
    else:
        text = defect["text"] if "text" in defect else limited(defect["limit"])
    why = defect["why"]
    broken(site, text)
    with seen(site):
        assert main(["list", "methods"]) == 0
        out, err = capfd.readouterr()
        assert "ode/rk4" in out
        assert "tiny" not in out
        assert err.startswith("plumbob: their-package 1.0 is left out: ")
        assert why in err
        assert err.count("\n") == 1
        for command in (
            ["run", SWING, "tiny/euler", "--step", "1e-3"],
            ["validate", "--methods", "tiny", "--out", str(site / "out")],
        ):
            assert main(command) == 2
            said = capfd.readouterr().err
            assert "their-package 1.0: " in said
            assert why in said
            assert said.count("\n") == 1
        assert not (site / "out").exists()


BAD = "return type('Bad', (), {'run': lambda self: %s, 'stepped': lambda self, part: 3})()"
WRONG_RUNS = {
    "prepare raises RuntimeError: no licence": "raise RuntimeError('no licence')",
    "prepare raises AssertionError: raised in prepare": "raise AssertionError",
    "what it prepares has no run()": "return None",
    "run raises ZeroDivisionError: division by zero": BAD % "1 / 0",
    "a run returns int in place of a Trajectory": BAD % "3",
}


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("why", WRONG_RUNS)
def test_an_engine_that_raises_is_a_verdict(why, site, tmp_path, monkeypatch, capsys):
    """The study goes on: its other methods have their verdicts, and the exit code is 1."""
    broken(site, ENGINE.replace("return stepped(case, step, build)", WRONG_RUNS[why]))
    without_pages(monkeypatch)
    with seen(site):
        found = validated(tmp_path, capsys, SWING, "tiny,ode/euler")
    assert found.code == 1
    assert f"their-package 1.0: {why}" in found.failure(SWING, "tiny/euler")
    assert found.failure(SWING, "ode/euler") == ""


@pytest.mark.long(keep=3)
@pytest.mark.parametrize("defect", DEFECTS["systems"].values(), ids=DEFECTS["systems"])
def test_a_broken_system_costs_a_line(defect, site, capsys):
    text = changed(SYSTEM, defect["right"], defect["wrong"])
    why = defect["why"]
    broken(site, text, entry_points.SYSTEMS, "falling-body")
    with seen(site):
        assert main(["list", "systems"]) == 0
        out, err = capsys.readouterr()
        assert "falling" not in out
        assert why in err
        assert err.count("\n") == 1
        for command in (
            ["solve", "falling-body", "--times", "1"],
            ["validate", "--scenes", "falling-body/*", "--out", str(site / "out")],
        ):
            assert main(command) == 2
            said = capsys.readouterr().err
            assert why in said
            assert said.count("\n") == 1
