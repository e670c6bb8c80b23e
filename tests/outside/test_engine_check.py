"""`plumbob check-engine`: what an adapter promises is seen, and each small defect turns its check
red."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from plumbob.models import entry_points
from plumbob.reports.cli import main
from plumbob.reports.judge.engine_check import CHECKS
from plumbob.tests.outside.installed_packages import PACKAGES, install, install_folder, seen

ENGINE = (PACKAGES / "tiny_engine" / "tiny_engine.py").read_text("utf-8")
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


def wrapped(run: str = "run", stepped: str = "self.inner.stepped(fraction)") -> str:
    """The engine with simulations that return something else."""
    text = ENGINE.replace(RETURN, "return Wrapped(stepped(case, step, build))")
    return text + WRAPPED.format(run=run, stepped=stepped)


def changed(right: str, wrong: str) -> str:
    """The engine with one piece of its text replaced."""
    assert right in ENGINE
    return ENGINE.replace(right, wrong)


FIRST = "for _ in range(first, last):"
DEFECTS = {
    "refuses": (
        "builds",
        changed(
            RETURN, "raise __import__('plumbob.engines.method', fromlist='x').Unsupported('no')"
        ),
        "and says: no",
    ),
    "raises": ("builds", changed(RETURN, "raise RuntimeError('no licence')"), "no licence"),
    "random": (
        "repeats itself",
        changed(
            "state = [pendulum.theta,",
            "state = [pendulum.theta * (1 + 1e-9 * __import__('random').random()),",
        ),
        "theta of run 2",
    ),
    "a step late": (
        "samples at its steps",
        changed("        return Built(", "        advance(0, 1)\n        return Built("),
        "off the start",
    ),
    "a step late from the first": (
        "samples at its steps",
        changed(FIRST, "for _ in range(first - (first == 0), last):"),
        "steps ahead of time",
    ),
    "a step early": (
        "samples at its steps",
        changed(FIRST, "for _ in range(first + (first == 0), last):"),
        "steps ahead of time",
    ),
    "a step too many a sample": (
        "samples at its steps",
        changed(FIRST, "for _ in range(first, last + (last - first == 3)):"),
        "is not that of a run of",
    ),
    "times": (
        "samples at its steps",
        wrapped("replace(run, times=run.times + 1e-3)"),
        "its times begin at 0.001 s",
    ),
    "prints": (
        "writes nothing",
        changed("        state = [", "        print('hello')\n        state = ["),
        "it prints: hello",
    ),
    "writes": (
        "writes nothing",
        changed("        state = [", "        open('log.txt', 'w').close()\n        state = ["),
        "it leaves log.txt",
    ),
    "raises when lost": (
        "reports divergence",
        changed(FIRST, f"{FIRST}\n                assert abs(state[1]) < 50, 'lost'"),
        "lost",
    ),
    "keeps what is not finite": (
        "reports divergence",
        wrapped(
            "replace(run, observables={n: v / (abs(v) < 50) for n, v in run.observables.items()})"
        ),
        "",
    ),
    "counts one step": ("counts its cost", wrapped("replace(run, steps=1)"), "counts 1 steps"),
    "no time": ("counts its cost", wrapped("replace(run, seconds=0.0)"), "takes no time"),
    "not stepped": ("counts its cost", wrapped(stepped="Stepping(0, 0.0)"), "counts no steps"),
    "all of it": ("counts its cost", wrapped(stepped="self.inner.stepped(1.0)"), "stepped(0.5)"),
    "gravity": ("shows its order", changed("pendulum.gravity /", "1.01 * pendulum.gravity /"), ""),
    "gravity, no theory": (
        "shows its order",
        changed("pendulum.gravity /", "1.01 * pendulum.gravity /").replace(
            "Scheme(EULER)", 'Scheme("own")'
        ),
        "not-converging",
    ),
    "order, no theory": (
        "shows its order",
        changed("Scheme(EULER), 1", 'Scheme("own"), 2'),
        "declared 2",
    ),
    "scheme": ("shows its order", changed("Scheme(EULER), 1", 'Scheme("rk4"), 4'), ""),
}


def outcome(
    site: Path, text: str, capsys: pytest.CaptureFixture[str]
) -> tuple[int, dict[str, dict[str, str]]]:
    """Exit code and checks of an engine with this text."""
    install(site, "theirs", {entry_points.ENGINES: {"tiny": "theirs:ENGINE"}}, theirs=text)
    with seen(site):
        code = main(["check-engine", "tiny", "--scenes", "simple-pendulum/free-large", "--json"])
    return code, {check["name"]: check for check in json.loads(capsys.readouterr().out)}


@pytest.mark.long(keep=4)
@pytest.mark.parametrize("defect", DEFECTS)
def test_a_defect_turns_its_check_red(
    defect: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    check, text, why = DEFECTS[defect]
    code, found = outcome(tmp_path, text, capsys)
    assert code == 1
    assert found[check]["status"] == "fail"
    assert why in found[check]["detail"]


def test_every_check_has_a_defect_that_it_sees() -> None:
    assert {check for check, _, _ in DEFECTS.values()} == set(CHECKS)


def test_the_example_passes_with_a_line_a_check(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    install_folder(tmp_path / "site", "tiny_engine")
    monkeypatch.chdir(tmp_path)
    with seen(tmp_path / "site"):
        assert main(["check-engine", "tiny"]) == 0
    out, err = capsys.readouterr()
    lines = out.splitlines()
    assert [line[:4] for line in lines] == ["pass"] * len(CHECKS)
    assert [name in line for name, line in zip(CHECKS, lines, strict=True)] == [True] * len(lines)
    assert err == ""
    assert os.listdir(tmp_path) == ["site"]


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("name", ["ode/leapfrog", "ode/dop853", "mujoco/euler", "pymunk/tight"])
def test_engines_of_ours_pass(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check-engine", name, "--scenes", "*/free-small"]) == 0
    assert "fail" not in capsys.readouterr().out


def test_what_is_asked_for_has_to_be_there(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check-engine", "none"]) == 2
    assert "methods = 'none'" in capsys.readouterr().err
    assert main(["check-engine", "pymunk/side", "--scenes", "free-body/*"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


SECOND_ORDER = ENGINE.replace("Scheme(EULER), 1", 'Scheme("own"), 2').replace(
    """                state[1] -= step * pendulum.gravity / pendulum.length * math.sin(state[0])
                state[0] += step * state[1]
""",
    """                half = step / 2 * pendulum.gravity / pendulum.length
                state[1] -= half * math.sin(state[0])
                state[0] += step * state[1]
                state[1] -= half * math.sin(state[0])
""",
)


@pytest.mark.parametrize("late", [False, True])
def test_a_late_sample_reduces_the_order_of_a_better_method(
    late: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = "for _ in range(first - (first == 0), last):"
    text = SECOND_ORDER.replace(FIRST, wrong) if late else SECOND_ORDER
    code, found = outcome(tmp_path, text, capsys)
    assert code == int(late)
    for check in ("samples at its steps", "shows its order"):
        assert found[check]["status"] == ("fail" if late else "pass"), found[check]
