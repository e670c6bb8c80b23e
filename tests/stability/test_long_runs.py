"""The time after which a method is wrong, against runs in plain numbers."""

import math

import numpy as np
import pytest

from plumbob.analytic.errors.smooth_motion.rotor_errors import RotorErrors
from plumbob.analytic.errors.stability.long_runs import PeriodicMotion
from plumbob.analytic.schemes import EULER, LEAPFROG, RK4, Scheme
from plumbob.analytic.stability import LEVELS
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.tests.support import fixed_step

RUNS = (
    ("simple-pendulum/free-large", Scheme(EULER), 0.03, "linear"),
    ("simple-pendulum/free-large", Scheme(LEAPFROG), 0.02, "linear"),
    ("simple-pendulum/free-large", Scheme(RK4), 0.05, "quadratic"),
    ("simple-pendulum/rotating-slow", Scheme(LEAPFROG), 0.004, "linear"),
    ("simple-pendulum/rotating-slow", Scheme(RK4), 0.05, "quadratic"),
    ("cone-pendulum/deep-well", Scheme(EULER), 2e-3, "linear"),
    ("cone-pendulum/deep-well", Scheme(LEAPFROG), 2e-3, "linear"),
    ("cone-pendulum/deep-well", Scheme(RK4), 6e-3, "quadratic"),
)
SHORTEST = 12  # a period is an eleventh of that: the bar


def scales(name):
    case = case_of(find_scene(name))
    return {q.observable: q.scale for q in case.system.quantities(case)}


def motion(name):
    case = case_of(find_scene(name))
    pendulum = case.problem.motion if name.startswith("cone") else case.problem.elliptic
    start = case.reference.observe(np.zeros(1))
    first = float(start["theta"][0]), float(start["theta_dot"][0])
    return PeriodicMotion(RotorErrors(pendulum.rotor, *first, case.reference), pendulum.period)


@pytest.mark.parametrize(("name", "scheme", "step", "growth"), RUNS, ids=str)
def test_the_time_until_an_error_is_as_predicted(name, scheme, step, growth):
    """Within 1.1 at 1 % and at 10 %, but in the first SHORTEST periods: two terms of the series, an
    interpolated orbit, and an error that is at its largest once a period."""
    exact = motion(name)
    predicted = exact.long_run(scheme, step, scales(name)["theta"])
    assert predicted.growth == growth
    steps = math.ceil((1.2 * predicted.times[0.1] + 2.0 * exact.period) / step)
    of = exact.errors
    theta, _ = fixed_step.run(of.rotor, of.theta, of.theta_dot, step, steps, scheme)
    truth = of.exact.observe(np.arange(steps + 1, dtype=np.float64) * step)["theta"]
    errors = np.abs(theta - truth) / scales(name)["theta"]
    levels = [level for level in LEVELS[:2] if predicted.times[level] > SHORTEST * exact.period]
    assert levels
    for level in levels:
        measured = step * int(np.flatnonzero(errors >= level)[0])
        assert 1.0 / 1.1 < measured / predicted.times[level] < 1.1


FOLLOWED = (
    ("simple-pendulum/damped-large", Scheme(EULER), 0.1, "decaying"),
    ("simple-pendulum/damped-large", Scheme(LEAPFROG), 0.1, "decaying"),
    ("simple-pendulum/damped-large", Scheme(RK4), 0.2, "decaying"),
    ("simple-pendulum/forced-large", Scheme(EULER), 0.05, "decaying"),
    ("simple-pendulum/forced-large", Scheme(LEAPFROG), 0.08, "decaying"),
    ("simple-pendulum/forced-large", Scheme(RK4), 0.3, "decaying"),
    ("simple-pendulum/forced-chaotic", Scheme(EULER), 0.01, "exponential"),
    ("simple-pendulum/forced-chaotic", Scheme(LEAPFROG), 0.02, "exponential"),
    ("simple-pendulum/forced-chaotic", Scheme(RK4), 0.1, "exponential"),
    ("simple-pendulum/near-top-1e-6", Scheme(RK4), 0.01, "exponential"),
)
LATER = 0.1  # [s]: two steps at most


@pytest.mark.long
@pytest.mark.parametrize(("name", "scheme", "step", "growth"), FOLLOWED, ids=str)
def test_errors_that_die_or_grow_exponentially_are_followed(name, scheme, step, growth):
    case = case_of(find_scene(name))
    assert case.system.stability is not None
    predicted = case.system.stability(case.problem).long_run(scheme, step, scales(name))
    assert predicted.growth == growth
    start = case.problem.started
    steps = math.ceil(min(1.2 * predicted.times[0.1] + 2.0, 140.0) / step)
    theta, _ = fixed_step.run(start.rotor, start.theta, start.theta_dot, step, steps, scheme)
    times = np.arange(steps + 1, dtype=np.float64) * step
    errors = np.abs(theta - case.reference.observe(times)["theta"]) / scales(name)["theta"]
    assert predicted.times[0.01] < math.inf
    for level in LEVELS[:2]:
        reached = np.flatnonzero(errors >= level)
        if math.isinf(predicted.times[level]):
            assert not reached.size
        else:
            assert times[reached[0]] == pytest.approx(
                predicted.times[level], rel=0.1, abs=LATER
            )
