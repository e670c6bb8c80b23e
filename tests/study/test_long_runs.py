"""How long a method stays right, by an engine's runs: as predicted, and red for what is wrong."""

import math
from dataclasses import replace
from functools import cache

import pytest

from plumbob.analytic.stability import LEVELS
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.long_runs import LongRunSearch, MeasuredLongRun
from plumbob.reports.judge.long_runs import judged_long_run

SWING, CHAOS = "simple-pendulum/free-large", "simple-pendulum/forced-chaotic"
SCENES = (
    SWING,
    CHAOS,
    "simple-pendulum/forced-large",
    "simple-pendulum/damped-large",
    "cone-pendulum/deep-well",
)
STEPS = 60_000


@cache
def run(scene, method, step=None):
    search = LongRunSearch(scene, method, step, STEPS)
    found = search.answer(find_method(method))
    assert isinstance(found, MeasuredLongRun)
    return judged_long_run(search, found)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("method", ["mujoco/euler", "ode/leapfrog", "ode/rk4"])
@pytest.mark.parametrize("scene", SCENES)
def test_runs_take_the_predicted_time_to_be_wrong(scene, method):
    judged = run(scene, method)
    assert judged.verdict == "predicted"
    assert judged.found.predicted is not None


@pytest.mark.rare(keep=2)
@pytest.mark.long(keep=2)
@pytest.mark.parametrize(
    ("scene", "method"),
    [
        ("free-body/flip", "mujoco/euler"),  # not leapfrog, whose error peaks between samples
        ("free-body/flip", "mujoco/implicit"),
        ("free-body/symmetric", "ode/leapfrog"),
        ("free-body/about-largest", "mujoco/rk4"),
    ],
)
def test_free_bodies_take_the_predicted_time_to_be_wrong(scene, method):
    judged = run(scene, method)
    assert judged.verdict == "predicted"
    assert judged.found.predicted is not None


@pytest.mark.long
def test_energy_is_bounded_drifts_as_predicted_or_is_lost():
    euler = run(SWING, "ode/euler").found
    rk4 = run(SWING, "ode/rk4").found
    assert euler.energy == "bounded"
    assert rk4.energy == "drifting"
    assert rk4.energy_rate == pytest.approx(rk4.predicted.energy_rate, rel=0.02)
    assert run(SWING, "ode/euler", 0.9).found.energy == "lost"


@pytest.mark.long
def test_chaos_grows_at_its_own_rate_and_ends_where_doubles_do():
    found = run(CHAOS, "ode/rk4", 0.02).found
    assert found.predicted.growth == "exponential"
    assert found.predicted.rate == pytest.approx(0.12, abs=0.01)
    assert set(found.times) == set(LEVELS)
    near = run("simple-pendulum/near-top-1e-6", "ode/leapfrog", 1e-3).found
    assert set(near.times) < set(LEVELS)
    assert "no longer" in near.stopped


@pytest.mark.parametrize("wrong", [0.8, 1.25, math.inf])
def test_a_wrong_time_is_red(wrong):
    right = run(SWING, "ode/leapfrog")
    assert right.verdict == "predicted"
    predicted = right.found.predicted
    times = {level: wrong * time for level, time in predicted.times.items()}
    found = replace(right.found, predicted=replace(predicted, times=times))
    judged = judged_long_run(right.search, found)
    assert (judged.verdict, bool(judged.surprise)) == ("off-prediction", True)
