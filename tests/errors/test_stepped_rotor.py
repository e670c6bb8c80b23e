"""Steps taken in plain numbers beside the series in the step, and beside the engines' own."""

import math

import numpy as np
import pytest

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.tests.support.fixed_step import run


def stepped(name, method, step):
    """What theory steps, the errors of the engine's run, and its number of steps."""
    scene = find_scene(name)
    how = find_method(method)
    if not installed(engine_of(how)):
        pytest.skip(f"{how.engine} is not installed")
    case = case_of(scene)
    found, trajectory = measure(case, how, step)
    truth = case.reference.observe(trajectory.times)
    errors = {
        n: trajectory.observables[n] - truth[n] for n in truth if n in trajectory.observables
    }
    return case.errors.at_step(how.scheme, step, trajectory.times), errors, found.steps


# Held from both sides: the rounding of an engine stays within what is derived for it, and is not
# far below it: a start next to the top is the same double for all, the largest part of it.
RUNS = (
    ("simple-pendulum/rotating-slow", "mujoco/euler", 1e-2),
    ("simple-pendulum/rotating-slow", "mujoco/implicitfast", 5e-3),  # it turns to 177 rad
    ("simple-pendulum/rotating-slow", "mujoco/rk4", 1e-1),
    ("simple-pendulum/rotating-slow", "ode/rk4", 1e-1),
    ("simple-pendulum/rotating-slow", "pymunk/default", 1e-2),
    ("simple-pendulum/rotating-slow", "pymunk/tight", 2e-2),
    ("simple-pendulum/near-top-1e-6", "pymunk/default", 5e-4),
    ("simple-pendulum/damped-rotating", "mujoco/implicitfast", 5e-2),
    ("simple-pendulum/forced-large", "mujoco/rk4+midpoint", 1e-1),
    ("linear-pendulum/forced-large", "mujoco/discrete", 1e-1),
    ("linear-pendulum/forced-large", "pymunk/spring", 1e-1),
    ("cone-pendulum/above-barrier-1e-6", "mujoco/euler", 2e-4),
    ("cone-pendulum/above-barrier-1e-6", "ode/leapfrog", 5e-4),
    # It starts at rest next to a saddle: roundings where it is fast are the largest part.
    ("cone-pendulum/equal-wells", "mujoco/euler", 5e-3),
    ("cone-pendulum/equal-wells", "pinocchio/aba+euler", 5e-3),
)


@pytest.mark.long(keep=3)
@pytest.mark.parametrize(("name", "method", "step"), RUNS)
def test_an_engine_takes_these_steps(name, method, step):
    theory, errors, steps = stepped(name, method, step)
    assert theory.uncertainty is not None
    parts = [
        np.abs(error - theory.errors[n]).max()
        / (theory.uncertainty[n].max() * (1 + 2 * math.sqrt(steps)))
        for n, error in errors.items()
    ]
    assert max(parts) < 1.0
    assert max(parts) > 1e-4 or not any(parts)  # leapfrog's are the same to the bit


def test_rounding_counts_where_the_motion_is_fast():
    """The response to rounding, beside the runs of a start and of a fast state that are changed."""
    case = case_of(find_scene("cone-pendulum/equal-wells"))
    theory, step, steps, change = case.errors, 5e-3, 1600, 1e-10
    rotor = theory.rotor
    times = step * np.arange(1, steps + 1)
    uncertainty = theory.at_step(Scheme(EULER), step, times).uncertainty["theta"].max()
    theta, rate = run(rotor, theory.theta, theory.theta_dot, step, steps, Scheme(EULER))
    responses = []
    for first in (0, int(np.abs(rate[:400]).argmax())):
        slower = rate[first] - change
        changed, _ = run(rotor, theta[first], slower, step, steps - first, Scheme(EULER))
        responses.append(np.abs(changed - theta[first:]).max() / change)
    by_start, by_fast_state = (ROUNDOFF * np.abs(rate).max() * r for r in responses)
    # A rounding of the start's rate acts three thousand times less than a rounding of the fast
    # rate. The angle and the force of the fast step are rounded, too: each as much as the rate.
    assert by_start < 1e-3 * by_fast_state
    assert 0.9 * by_fast_state < uncertainty < 4.0 * by_fast_state
