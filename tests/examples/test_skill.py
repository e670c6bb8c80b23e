"""SKILL.md, the guide for assistants: each of its commands runs as it stands and exits with 0, its
schemas and exit codes are the present ones, and it is shipped."""

import re
import shlex
from pathlib import Path

import mujoco
import numpy as np
import pytest

from plumbob.reports.cli import main
from plumbob.tests.difference.planted_changes import Motion

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "SKILL.md").read_text("utf-8")
COMMANDS = [
    line
    for block in re.findall(r"^```sh\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
    for line in block.splitlines()
]
ROD = """<mujoco model="rod"><option timestep=".01"/><worldbody><body name="rod">
<joint name="hinge" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .5 0 0" size=".02"/></body>
</worldbody><actuator><motor joint="hinge" ctrlrange="-1 1"/></actuator></mujoco>"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the files that the guide names."""
    there = tmp_path_factory.mktemp("skill")
    (there / "my.xml").write_text(ROD)
    model = mujoco.MjModel.from_xml_string(ROD)
    for name in ("a.npz", "b.npz"):
        np.savez(there / name, **Motion(model, 20).arrays())
    return there


@pytest.mark.rare
@pytest.mark.parametrize("line", COMMANDS)
def test_each_command_runs_as_it_stands(folder, monkeypatch, capsys, line):
    """What they print with --json is held to their schemas by tests/conftest.py."""
    monkeypatch.chdir(folder)
    program, *words = shlex.split(line)
    if "compare" in words and not (folder / "study").exists():
        (before,) = (other for other in COMMANDS if "--out study" in other)
        assert main(shlex.split(before)[1:]) == 0
        capsys.readouterr()
    assert program == "plumbob"
    assert main(words) == 0, line
    assert capsys.readouterr().out


def test_the_guide_has_the_exit_codes_of_the_readme():
    readme = (ROOT / "README.md").read_text("utf-8")
    codes = re.findall(r"^\| (\d+) \|", readme, re.MULTILINE)
    (line,) = re.findall(r"Exit codes: (.*?)\n- ", TEXT, re.DOTALL)
    assert re.findall(r"(?:^|; |: )(\d+) ", " ".join(line.split())) == codes


def test_the_guide_is_short_and_shipped():
    assert len(TEXT.splitlines()) <= 120
    assert '"SKILL.md"' in (ROOT / "pyproject.toml").read_text("utf-8")
