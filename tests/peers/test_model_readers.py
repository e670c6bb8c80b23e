"""What engines' own readers of model files take over, as `plumbob models check` tells it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from plumbob.engines.registry import find_engine, installed
from plumbob.reports.cli import main
from plumbob.reports.judge.model_readers import compared

ALL = (
    *("gravity", "timestep", "mass", "inertia", "armature", "damping", "stiffness"),
    *("frictionloss", "friction", "solref", "solimp", "gear"),
)
MODEL = """
<mujoco model="my">
  <option timestep="3e-3" gravity="0 0 -1.62"/>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 0.1" friction="0.7 0.005 0.0001"/>
    <body name="arm" pos="0 0 1">
      <inertial pos="0 0 -0.5" mass="1.7" diaginertia="0.11 0.12 0.13"/>
      <joint name="hinge" type="hinge" axis="0 -1 0" damping="0.31" armature="0.21"
             frictionloss="0.05" stiffness="0.4"/>
      <geom name="bob" type="sphere" size="0.1" pos="0 0 -0.5" friction="0.6 0.005 0.0001"/>
    </body>
  </worldbody>
  <actuator><motor name="motor" joint="hinge" gear="7"/></actuator>
</mujoco>
"""
READ = {  # with DART 6.20.0, Drake 1.51.1, Pinocchio 4.1.0 and PyBullet 3.2.7
    "dart": ("mass", "damping", "friction"),
    "drake": ("gravity", "mass", "inertia", "armature", "damping", "friction", "gear"),
    "pinocchio": ("mass", "inertia", "armature", "damping", "frictionloss"),
    "pybullet": ("mass", "friction"),
}


def test_what_each_reader_takes_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (file := tmp_path / "my.xml").write_text(MODEL, "utf-8")
    assert main(["models", "check", str(file), "--json"]) == 0
    readers = {reader["engine"]: reader for reader in json.loads(capsys.readouterr().out)}
    assert set(readers) == {"mujoco", *(e for e in READ if installed(find_engine(e)))}
    for engine, found in readers.items():
        _held(engine, found)


def _held(engine: str, found: dict[str, Any]) -> None:
    """The fields that a reader takes over are the known ones, and the others are named."""
    assert found["refuses"] == "", engine
    assert tuple(found["read"]) == (ALL if engine == "mujoco" else READ[engine])
    dropped = () if engine == "mujoco" else tuple(f for f in ALL if f not in READ[engine])
    assert tuple(found["dropped"] or ()) == dropped


STATED = {("gravity", ""): (0.0, 0.0, -9.81), ("mass", "arm"): (1.7,), ("friction", "bob"): (0.6,)}


def test_what_is_dropped_is_said_with_what_is_there_instead() -> None:
    given = {("gravity", ""): (0.0, 0.0, -9.81), ("mass", "arm"): (1.70004,)}
    found = compared("other", STATED, given)
    assert found.read == ("gravity",)
    assert found.dropped == {"mass": "arm: 1.7 for 1.7", "friction": ""}
    by_body = {**STATED, ("friction", "arm"): (0.6,)}
    del by_body["friction", "bob"]
    assert compared("other", STATED, by_body).dropped == {}
    assert compared("other", STATED, STATED, ("gravity",)).read == ("mass", "friction")


@pytest.mark.parametrize("text", ["", "<mujoco>", "<mujoco><option gravity='a'/></mujoco>"])
def test_what_is_no_model_is_bad_input(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (file := tmp_path / "my.xml").write_text(text, "utf-8")
    assert main(["models", "check", str(file)]) == 2
    said = capsys.readouterr().err
    assert said.startswith("plumbob: FILE = ")
    assert said.count("\n") == 1
