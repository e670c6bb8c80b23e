"""plumbob recommend asks for what is not stored, answers for families, and refuses bad input."""

import json
import re

import pytest

from plumbob.engines.registry import methods as find_methods
from plumbob.reports.cli import main
from plumbob.reports.commands import recommend

FEW = "mujoco/rk4,ode/rk4,mujoco/euler,mujoco/euler+coulomb,mujoco/euler+reduced"
CONE, BALL = "cone-pendulum/rotating-base", "rolling-ball/slide-to-roll"


@pytest.fixture
def few(monkeypatch):
    """A few methods in place of all, in this process: others take longer to begin than to run."""
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    monkeypatch.setattr(recommend, "find_methods", lambda: find_methods(FEW))


def answer(capsys, folder, *words):
    """What the command prints as JSON, of a question that can be answered."""
    assert main(["recommend", *words, "--out", str(folder), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    return found


@pytest.mark.long
@pytest.mark.usefixtures("few")
def test_what_is_not_stored_is_run_once(tmp_path, capsys):
    def choice(*more, error="--error"):
        found = answer(capsys, tmp_path, CONE, error, "1e-4", *more)
        assert (found["observable"], found["unit"]) == ("theta", "rad")
        chosen = found["choice"]
        assert chosen["error"] <= 1e-4
        return chosen

    first = choice()
    assert first["step"] < 0.8 * first["limit"]["step"]
    file = tmp_path / recommend.FILE
    held = file.read_bytes()
    assert choice() == first
    assert file.read_bytes() == held  # nothing was run, so nothing stored
    assert main(["recommend", CONE, "--error", "1e-4", "--stored", "--out", str(tmp_path)]) == 2
    capsys.readouterr()
    (tmp_path / "file").touch()
    # nothing is stored
    assert answer(capsys, tmp_path / "file", CONE, "--error", "1e-4")["choice"]
    # The scale of a rotation is one radian: absolute and relative are the same.
    assert choice("--observable", "theta", error="--absolute")["step"] == first["step"]
    assert choice("--engine", "mujoco")["method"].startswith("mujoco/")
    # With other parameters it is another scene, and neither is taken for the other.
    slow = choice("--set", "platform_rate=0")
    assert slow["step"] != first["step"]
    assert (choice(), choice("--set", "platform_rate=0")) == (first, slow)


@pytest.mark.usefixtures("few")
def test_json_has_the_settings_of_a_file_beside_the_answer(tmp_path, capsys):
    """The schema of the command allows them: tests/conftest.py holds what is printed to it."""
    file = tmp_path / "my.xml"
    file.write_text('<mujoco><option timestep="0.005"/></mujoco>', "utf-8")
    found = answer(capsys, tmp_path, BALL, "--error", "1e-3", "--like", str(file))
    (settings,) = found["user_settings"]
    assert (settings["scene"], settings["step"]) == (BALL, 0.005)
    assert settings["error"] > 0.0


@pytest.mark.usefixtures("few")
def test_a_budget_that_is_spent_ends_in_one_line(tmp_path, capsys):
    words = [
        "recommend",
        "linear-pendulum/overdamped",
        "--error",
        "1e-3",
        "--out",
        str(tmp_path),
    ]
    assert main([*words, "--budget", "1e-9"]) == 3
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    # what had begun when the budget was spent is kept
    assert re.search(
        r"more than 1e-09 s of processor time \(--budget\): [01] of \d+ results", err
    )
    assert main(words) == 0


@pytest.mark.long
@pytest.mark.usefixtures("few")
def test_a_family_of_lines_takes_a_full_model_that_converges(tmp_path, capsys):
    family, alone, line = (
        answer(capsys, tmp_path, name, "--error", "1e-3")
        for name in ("capsule-line/heading-0[34]?", "capsule-line/heading-030", "capsule-line")
    )
    assert family["scenes"] == ["capsule-line/heading-030", "capsule-line/heading-045"]
    assert family["choice"]["error"] <= 1e-3
    assert alone["choice"]["step"] >= 0.9 * family["choice"]["step"]
    for found in (family, alone, line):
        assert found["choice"]["method"] == "mujoco/euler+coulomb"
    assert line["surrogate"]["method"] == "mujoco/euler+reduced"
    assert line["surrogate"]["surrogate"]
