"""plumbob recommend asks for what is not stored, answers for families, and refuses bad input."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from plumbob.engines.registry import methods as find_methods
from plumbob.reports.cli import main
from plumbob.reports.commands import recommend

FEW = "mujoco/rk4,ode/rk4"
FEW_OF_A_CAPSULE = "mujoco/euler,mujoco/euler+coulomb,mujoco/euler+reduced"
CONE = "cone-pendulum/rotating-base"


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """A few methods in place of all, in this process: others take longer to begin than to run."""
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    chosen = {
        "cone": find_methods(FEW),
        "capsule": find_methods(FEW_OF_A_CAPSULE),
    }
    every = recommend._methods

    def some(engine: Any, known: Any, stored: bool) -> Any:
        names = {m.name for found in chosen.values() for m in found}
        return tuple(m for m in every(engine, known, stored) if m.name in names)

    monkeypatch.setattr(recommend, "_methods", some)


def answer(capsys: pytest.CaptureFixture[str], folder: Path, *words: str) -> dict[str, Any]:
    """What the command prints as JSON, of a question that can be answered."""
    assert main(["recommend", *words, "--out", str(folder), "--json"]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


@pytest.mark.long
@pytest.mark.usefixtures("few")
def test_what_is_not_stored_is_run_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first = answer(capsys, tmp_path, CONE, "--error", "1e-4")
    file = tmp_path / recommend.FILE
    size = file.stat().st_size
    again = answer(capsys, tmp_path, CONE, "--error", "1e-4")
    assert again["choice"] == first["choice"]
    assert file.stat().st_size == size  # nothing was run, so nothing stored
    assert (first["observable"], first["unit"], first["error"]) == ("theta", "rad", 1e-4)
    assert first["choice"]["error"] <= 1e-4
    stored = answer(capsys, tmp_path, CONE, "--error", "1e-4", "--stored")
    assert stored["choice"]["method"] == first["choice"]["method"]
    # The scale of a rotation is one radian: absolute and relative are the same.
    same = answer(capsys, tmp_path, CONE, "--absolute", "1e-4", "--observable", "theta")
    assert same["choice"]["step"] == first["choice"]["step"]
    mujoco = answer(capsys, tmp_path, CONE, "--error", "1e-4", "--engine", "mujoco")
    assert mujoco["choice"]["method"] == "mujoco/rk4"
    # With other parameters it is another scene, and neither is taken for the other.
    slow = ("--set", "platform_rate=0")
    other = answer(capsys, tmp_path, CONE, "--error", "1e-4", *slow)
    assert other["choice"]["step"] != first["choice"]["step"]
    assert answer(capsys, tmp_path, CONE, "--error", "1e-4")["choice"] == first["choice"]
    assert answer(capsys, tmp_path, CONE, "--error", "1e-4", *slow)["choice"] == other["choice"]


@pytest.mark.long
@pytest.mark.usefixtures("few")
def test_a_family_of_lines_takes_a_full_model_that_converges(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pattern = "capsule-line/heading-0[34]?"
    found = answer(capsys, tmp_path, pattern, "--error", "1e-3")
    assert found["scenes"] == ["capsule-line/heading-030", "capsule-line/heading-045"]
    assert found["choice"]["method"] == "mujoco/euler+coulomb"
    assert found["choice"]["error"] <= 1e-3
    alone = answer(capsys, tmp_path, "capsule-line/heading-030", "--error", "1e-3")
    assert alone["choice"]["method"] == "mujoco/euler+coulomb"
    assert alone["choice"]["step"] >= 0.9 * found["choice"]["step"]
    line = answer(capsys, tmp_path, "capsule-line", "--error", "1e-3")
    assert line["choice"]["method"] == "mujoco/euler+coulomb"
    assert line["surrogate"]["method"] == "mujoco/euler+reduced"
    assert line["surrogate"]["surrogate"]
