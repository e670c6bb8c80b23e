"""Sabotage of one thing at a time turns `validate` red, and the JUnit file with it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Case
from plumbob.tests.commands.outcomes import Outcome, changed_runs, validated, without_pages

PENDULUM, LINE = "simple-pendulum/free-small", "capsule-line/ca1"
Validate = Callable[[str, str], Outcome]


@pytest.fixture
def validate(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Validate:
    """A `validate` of a scene and method."""
    without_pages(monkeypatch)
    return partial(validated, tmp_path, capsys)


@pytest.mark.parametrize(
    ("scene", "method", "observable"),
    [
        (PENDULUM, "mujoco/rk4", "tension"),
        (LINE, "mujoco/euler", "normal_force_2"),
        ("cone-pendulum/rotating-base", "mujoco/euler", "theta_dot"),
    ],
)  # fmt: skip
def test_an_observable_that_an_engine_drops(
    validate: Validate,
    monkeypatch: pytest.MonkeyPatch,
    scene: str,
    method: str,
    observable: str,
) -> None:
    def drop(case: Case, run: Trajectory) -> Trajectory:
        kept = {name: seen for name, seen in run.observables.items() if name != observable}
        return replace(run, observables=kept)

    changed_runs(monkeypatch, method.partition("/")[0], drop)
    found = validate(scene, method)
    assert found.code == 1
    assert found.failure(scene, method).endswith(f"the run leaves out {observable}")
    assert found.junit.attrib["failures"] == "1"
