"""The action and the hook: their own commands, run in a scratch repository."""

import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import plumbob

ROOT = Path(plumbob.__file__).parent

ROD = """<mujoco>
  <worldbody><body><joint axis="0 1 0"/><geom size=".1" pos=".5 0 0"/></body></worldbody>
  <option timestep="0.005"/>
</mujoco>
"""


def _run(command, folder, **env):
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return subprocess.run(
        ["bash", "-e", "-c", command],
        cwd=folder,
        env={**os.environ, "PATH": path, **env},
        text=True,
        capture_output=True,
        check=False,
    )


@pytest.mark.long
def test_the_actions_step_fails_on_the_line_that_a_change_sets(tmp_path):
    """Ten times the step: the error exceeds what passes, on the third line of the file."""
    action = (ROOT / ".github/actions/audit/action.yml").read_text("utf-8")
    (script,) = re.findall(r"run: \|\n((?: {8}.*\n)+)", action)
    inputs = dict(
        re.findall(r"^ {8}([A-Z]+): \$\{\{ inputs\.(\w+) \}\}$", action, re.MULTILINE)
    )
    assert inputs == {name: name.lower() for name in ("FILES", "METRES", "ENGINES", "OPTIONS")}
    given = {"FILES": "rod.xml", "METRES": "0.01", "OPTIONS": "--duration 0.2 --budget 60"}
    for step, code, kind in (("0.005", 0, "notice"), ("0.05", 1, "error")):
        (tmp_path / "rod.xml").write_text(ROD.replace("0.005", step))
        done = _run(textwrap.dedent(script), tmp_path, **given)
        assert done.returncode == code, done.stderr
        annotated = [line for line in done.stderr.splitlines() if line.startswith("::")]
        assert [line.partition(",title")[0] for line in annotated] == [
            f"::{kind} file=rod.xml,line=3"
        ]
    assert (tmp_path / "plumbob-audit" / "audit-rod.html").is_file()


def test_the_hooks_command_takes_files(tmp_path):
    hooks = (ROOT / ".pre-commit-hooks.yaml").read_text("utf-8")
    (entry,) = re.findall(r"entry: (.*)", hooks)
    (pattern,) = re.findall(r"files: (.*)", hooks)
    assert [bool(re.search(pattern, name)) for name in ("a/b.xml", "r.urdf", "a.py")] == [
        1,
        1,
        0,
    ]
    (tmp_path / "bad.xml").write_text("<mujoco><no_such/></mujoco>")
    (tmp_path / "package.xml").write_text("<package/>")
    assert _run(f"{entry} bad.xml package.xml", tmp_path).returncode == 2
    assert _run(f"{entry} package.xml", tmp_path).returncode == 0
