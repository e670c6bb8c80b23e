"""Steps taken in plain numbers beside the series in the step, and beside the engines' own."""

import math
from dataclasses import asdict

import numpy as np
import pytest

from plumbob.analytic.errors.smooth_motion.global_error import RotorErrors
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene

# every coefficient at once, two terms of the potential among them
ROTOR = DrivenRotor(3.0, 1.0, 9.0, 0.3, 1.2, 2.1, 0.4, 0.7)
START = (0.7, 1.3)


def stepped(name, method, step):
    """What theory steps, the errors of the engine's run, and its number of steps."""
    scene, how = find_scene(name), find_method(method)
    case = case_of(scene)
    found, run = measure(case, how, step)
    truth = case.reference.observe(run.times)
    errors = {n: run.observables[n] - truth[n] for n in truth if n in run.observables}
    return case.errors.at_step(how.scheme, step, run.times), errors, found.steps


@pytest.mark.long
def test_a_unit_in_the_last_place_moves_it_by_the_uncertainty():
    times, scheme, off = 0.05 * np.arange(0.0, 401.0), Scheme(EULER), 1e-8

    def theta(rotor):
        theory = RotorErrors(rotor, *START)
        stepped = theory.at_step(scheme, 0.05, times).errors["theta"]
        return np.asarray(stepped + theory.exact.observe(times)["theta"])

    changed = DrivenRotor(**{name: value * (1 + off) for name, value in asdict(ROTOR).items()})
    moved = np.maximum.accumulate(np.abs(theta(changed) - theta(ROTOR))) * 2**-52 / off
    uncertain = RotorErrors(ROTOR, *START).at_step(scheme, 0.05, times).uncertainty
    ratio = np.maximum.accumulate(uncertain["theta"])[times > 5.0] / moved[times > 5.0]
    assert ratio.min() > 0.5  # the roundings of the start are nudged beside them
    assert np.median(ratio) < 5.0


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
    assert 1e-4 < max(parts) < 1.0
