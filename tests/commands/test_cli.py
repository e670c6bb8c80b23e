"""The command line as a user types it: answers, one clear line for bad input, exit codes."""

import json
import os
import shlex
import subprocess
import sys

import pytest

from plumbob import __version__
from plumbob.models.registry import systems
from plumbob.reports.cli import COMMANDS, main, parser
from plumbob.reports.view.units import parameter_meanings


def ran(capsys, *words):
    """The exit code of a command, its output and its errors."""
    try:
        code = main(words)
    except SystemExit as stop:  # what argparse does
        code = int(stop.code or 0)
    out, err = capsys.readouterr()
    return code, out, err


@pytest.mark.parametrize("name", list(systems()))
def test_solve_answers_every_system(name, capsys):
    code, out, _ = ran(capsys, "solve", name, "--json")
    answer = json.loads(out)
    assert code == 0
    assert set(answer) >= {"scene", "parameters", "times", "observables"}
    assert {o.name for o in systems()[name].observables} <= set(answer["observables"])
    assert all(len(v) == len(answer["times"]) for v in answer["observables"].values())


def test_run_answers_with_its_budget(capsys):
    code, out, _ = ran(capsys, "run", "cone-pendulum", "mujoco/rk4", "--step", "1e-3", "--json")
    answer = json.loads(out)
    assert code == 0
    assert answer["verdict"] == "predicted"
    assert 0 < answer["errors"]["theta"] <= answer["tolerances"]["theta"]
    assert answer["tolerances"]["theta"] == pytest.approx(
        sum(answer["budget"]["theta"].values())
    )
    rounding = 2 * answer["steps"] ** 0.5 * answer["budget"]["theta"]["conditioning"]
    assert answer["budget"]["theta"]["round-off"] == pytest.approx(rounding, rel=1e-12, abs=0.0)
    computing = 1e-9 * answer["ns_per_step"] * answer["steps"]  # [s], for half a second
    assert answer["real_time_factor"] == pytest.approx(0.5 / computing, rel=1e-9)


def test_run_says_the_error_at_the_end_with_its_sign(capsys):
    words = ("run", "capsule-line", "mujoco/euler+reduced", "--step", "1e-3", "--json")
    answer = json.loads(ran(capsys, *words)[1])
    for name in ("displacement", "stroke_rate"):
        assert abs(answer["errors_at_end"][name]) <= answer["errors"][name]
    # the body stops late by a sawtooth, and goes too far, which is backward
    assert answer["errors_at_end"]["displacement"] == pytest.approx(-5.89e-7, rel=0.01)
    assert answer["predicted"]["displacement"] == pytest.approx(-5.89e-7, rel=0.01)


def test_list_and_cite_name_everything(capsys):
    _, out, _ = ran(capsys, "list")
    for system in systems().values():
        assert all(scene.name in out for scene in system.scenes)
    _, out, _ = ran(capsys, "cite")
    assert "Sudakov" in out


def test_version_is_printed(capsys):
    code, out, _ = ran(capsys, "--version")
    assert (code, out) == (0, f"plumbob {__version__}\n")


@pytest.mark.long
def test_the_umask_is_followed(tmp_path):
    """But by stores, to which SQLite gives others no right to write."""
    out = tmp_path / "out"
    site = tmp_path / "site"
    before = os.umask(0o027)
    try:
        words = f"--scenes linear-pendulum/overdamped --methods ode/rk4 --jobs 1 --out {out}"
        assert main(["validate", *words.split()]) == 0
        assert main(["report", str(out), "--publish", str(site)]) == 0
    finally:
        os.umask(before)
    modes = {(path.is_dir(), path.stat().st_mode & 0o777) for path in site.rglob("*")}
    assert modes == {(True, 0o750), (False, 0o640)}
    assert (out / "index.html").stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize("name", COMMANDS)
def test_help_shows_an_example_that_can_be_read_and_options_in_groups(name, capsys):
    code, out, _ = ran(capsys, name, "--help")
    assert code == 0
    lines = out.splitlines()
    (start,) = (i for i, line in enumerate(lines) if line in ("example:", "examples:"))
    examples = [line.strip() for line in lines[start + 1 : lines.index("", start)]]
    assert examples
    for example in examples:
        program, command, *words = shlex.split(example)
        assert (program, command) == ("plumbob", name)
        _, unknown = parser((name,)).parse_known_args([command, *words])
        assert not unknown
    titles = [line for line in lines if line.endswith(":") and not line.startswith(" ")]
    assert "output:" in titles or not any("  --json" in line for line in lines)


def test_every_parameter_has_a_meaning():
    names = {name for system in systems().values() for name in system.parameters}
    assert names == set(parameter_meanings())


def test_help_lists_the_parameters_of_the_named_scene_alone(capsys):
    """With the unit and the value of the scene; without a scene, --help says how to see them."""
    code, out, _ = ran(capsys, "run", "capsule-line/heading-030", "mujoco/euler", "--help")
    assert code == 0
    _, table = out.split("parameters of capsule-line/heading-030 that --set takes")
    rows = {line.split()[0]: line.split()[1:] for line in table.splitlines()[1:]}
    assert set(rows) == set(systems()["capsule-line"].parameters)
    assert rows["gravity"] == ["m/s²", "9.81", "gravitational", "acceleration"]
    assert rows["heading"][:2] == ["rad", "0.523599"]
    assert "theta" not in table
    _, out, _ = ran(capsys, "run", "--help")
    assert "With a scene, --help also lists its parameters" in out
    assert "gravity" not in out


@pytest.mark.long
@pytest.mark.parametrize(
    ("typed", "offered"), [("plumbob val", "validate"), ("plumbob sweep --sha", "--shard")]
)
def test_a_shell_is_offered_the_rest_of_a_word(typed, offered):
    pytest.importorskip("argcomplete", reason="the extra `completion` is missing")
    asked = {"_ARGCOMPLETE": "1", "COMP_LINE": typed, "COMP_POINT": str(len(typed))}
    command = f"{shlex.quote(sys.executable)} -m plumbob 8>&1 9>/dev/null"
    done = subprocess.run(command, shell=True, env={**os.environ, **asked}, capture_output=True)
    assert done.stdout.decode().strip() == offered
