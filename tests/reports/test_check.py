"""`check`, a test of one's own: it agrees with `validate`, and takes another expectation."""

import pytest

from plumbob import check
from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import KnownLimit
from plumbob.reports.cli import main
from plumbob.tests.commands.outcomes import declare

CONE, LINE, TURN = "cone-pendulum/deep-well", "capsule-line/ca1", "capsule-turn/0.3"


@pytest.mark.parametrize(
    ("scene", "method", "verdict"),
    [
        (CONE, "ode/rk4", "predicted"),
        (LINE, "mujoco/euler", "not-converging"),
        (TURN, "exact/closed-form", "unsupported"),
    ],
)
def test_without_a_step_it_says_what_validate_says(scene, method, verdict):
    assert check(scene, method).verdict == verdict


def test_a_known_limit_at_one_step_is_as_expected():
    assert check(LINE, "mujoco/euler", step=1e-3).verdict == "off-prediction"
    assert main(("run", LINE, "mujoco/euler", "--step", "1e-3")) == 0


@pytest.mark.parametrize("step", [None, 1e-3])
def test_what_is_not_expected_is_raised_with_its_runs(step, monkeypatch):
    limit = KnownLimit("cone-*", "ode/rk4", "diverged", "a limit of old")
    declare(monkeypatch, limit)
    with pytest.raises(
        AssertionError, match=r"predicted, expected diverged \(a limit of old"
    ) as raised:
        check(CONE, "ode/rk4", step)
    assert "at 0.001: predicted" in str(raised.value)
    assert "theta: error" in str(raised.value)


def test_another_expectation_takes_the_place_of_the_declared_one():
    assert check(LINE, "mujoco/euler", expect="not-converging").verdict == "not-converging"
    with pytest.raises(AssertionError, match="not-converging, expected predicted"):
        check(LINE, "mujoco/euler", expect="predicted")


def test_a_step_that_claims_nothing_and_a_missing_engine_do_not_pass(
    monkeypatch,
):
    with pytest.raises(AssertionError, match="pre-asymptotic, expected predicted"):
        check("simple-pendulum/free-large", "ode/euler", step=0.5)
    monkeypatch.setattr("plumbob.engines.study.measurement.installed", lambda engine: False)
    with pytest.raises(AssertionError, match="missing, expected predicted"):
        check(CONE, "ode/rk4")


def test_an_accuracy_of_ones_own():
    """A relative error just above the one asked for fails, also that of a known limit."""
    error = check(CONE, "mujoco/euler", step=1e-3).errors[1e-3]
    assert check(CONE, "mujoco/euler", step=1e-3, within=1.01 * error).verdict == "predicted"
    with pytest.raises(AssertionError, match="misses the accuracy asked for"):
        check(CONE, "mujoco/euler", step=1e-3, within=0.99 * error)
    with pytest.raises(AssertionError, match="misses the accuracy asked for"):
        check(LINE, "mujoco/euler", step=1e-3, within=1e-3)
    with pytest.raises(ParameterError, match="within"):
        check(CONE, "ode/rk4", within=-1.0)
