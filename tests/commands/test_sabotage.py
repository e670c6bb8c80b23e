"""Sabotage of one thing at a time turns `validate` red, and the JUnit file with it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from plumbob.analytic.reference import Array
from plumbob.engines.study import measurement
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Case
from plumbob.tests.commands.outcomes import (
    Outcome,
    break_engine,
    changed_runs,
    misread,
    validated,
    without_pages,
)

PENDULUM, LINE = "simple-pendulum/free-small", "capsule-line/ca1"
Validate = Callable[[str, str], Outcome]


@pytest.fixture
def validate(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Validate:
    """A `validate` of a scene and method."""
    without_pages(monkeypatch)
    return partial(validated, tmp_path, capsys)


CONE, TURNING = "cone-pendulum/rotating-base", "simple-pendulum/damped-rotating"
FORCED, SLOW = "simple-pendulum/forced-large", "simple-pendulum/rotating-slow"


def red(found: Outcome, scene: str, method: str) -> bool:
    """Whether the exit code, the terminal and the JUnit file say so."""
    said = f"UNEXPECTED {scene} {method}: " in found.out
    counted = found.junit.attrib["failures"] == "1" and bool(found.failure(scene, method))
    assert (found.code == 1) == said == counted
    return said


@pytest.mark.long(keep=2)
@pytest.mark.parametrize(
    ("scene", "method", "parameter", "factor"),
    [
        (CONE, "mujoco/euler", "platform_rate", 1.0 - 1e-4),
        (TURNING, "mujoco/euler", "damping_rate", 1.0 + 1e-3),
        (FORCED, "mujoco/euler", "gravity", 1.0 + 1e-4),
        (FORCED, "mujoco/rk4", "forcing_frequency", 1.0 + 1e-5),
        (SLOW, "mujoco/rk4", "gravity", 1.01),
        (SLOW, "mujoco/euler", "gravity", 1.01),
    ],
)
def test_a_parameter_that_is_read_wrongly(
    validate: Validate,
    monkeypatch: pytest.MonkeyPatch,
    scene: str,
    method: str,
    parameter: str,
    factor: float,
) -> None:
    assert parameter in find_scene(scene).parameters
    misread(monkeypatch, method.partition("/")[0], {parameter: factor})
    assert red(validate(scene, method), scene, method)


@pytest.mark.parametrize("factor", [1.0, 2.5, 0.4])
def test_a_known_limit_that_grows_or_shrinks(
    validate: Validate, monkeypatch: pytest.MonkeyPatch, factor: float
) -> None:
    def scaled(case: Case, run: Trajectory) -> Trajectory:
        exact = case.reference.observe(run.times)
        seen = {n: exact[n] + factor * (run.observables[n] - exact[n]) for n in run.observables}
        return replace(run, observables=seen)

    changed_runs(monkeypatch, "mujoco", scaled)
    assert red(validate(LINE, "mujoco/rk4"), LINE, "mujoco/rk4") == (factor != 1.0)


def test_a_prediction_with_its_sign_flipped(
    validate: Validate, monkeypatch: pytest.MonkeyPatch
) -> None:
    held = measurement._held

    def flipped(predicted: Array, *rest: Any) -> measurement.Prediction:
        return held(-predicted, *rest)

    monkeypatch.setattr(measurement, "_held", flipped)
    assert red(validate(CONE, "mujoco/euler"), CONE, "mujoco/euler")


def test_an_engine_that_refuses_every_model(
    validate: Validate, monkeypatch: pytest.MonkeyPatch
) -> None:
    break_engine(monkeypatch, "mujoco")
    assert red(validate(CONE, "mujoco/euler"), CONE, "mujoco/euler")


def test_nothing_is_red_without_sabotage(validate: Validate) -> None:
    assert not red(validate(CONE, "mujoco/euler"), CONE, "mujoco/euler")


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
    assert red(found, scene, method)
    assert found.failure(scene, method).endswith(f"the run leaves out {observable}")
