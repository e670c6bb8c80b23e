"""The ODE solvers on the cone pendulum and on user equations: error, order, divergence."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.engines.adapters.ode import ENGINE
from plumbob.engines.adapters.ode.simulation import adaptive
from plumbob.engines.registry import find_builder
from plumbob.models.largest import fastest_rate
from plumbob.tests.support.cone_scene import DEFAULT, SYSTEM, THETA, scene

METHODS = {method.name: method for method in ENGINE.methods}


def run(method, step, duration=0.5, **given):
    """Run the default scene, with some of its fields changed."""
    return ENGINE.prepare(SYSTEM.case(scene(duration, **given)), method, step).run()


def error(method, step, **given):
    """Error of theta [rad] at 0.5 s relative to the default scene, for any scene that was run."""
    trajectory = run(method, step, **given)
    assert trajectory.times[-1] == pytest.approx(0.5, abs=1e-12)
    return float(trajectory.observables["theta"][-1]) - THETA


def test_absolute_tolerances_are_of_an_angle_and_of_the_largest_speed():
    asked = []

    class Recorder:
        def __init__(self, *_, rtol, atol):
            asked.extend((rtol, *atol))
            raise ValueError("enough")

    case = SYSTEM.case(scene())
    builder = find_builder("ode", SYSTEM)
    equation = builder.build(case.problem, METHODS["ode/dop853"])
    adaptive(equation, Recorder, 1e-6, case.scene.duration).run()
    speed = fastest_rate(DEFAULT)
    assert speed > 37.0
    assert asked == pytest.approx([1e-6, 1e-6, 1e-6 * speed], rel=1e-12)


def test_no_motion_exceeds_the_speed_that_limits_are_based_on():
    generator = np.random.default_rng(1)
    for _ in range(30):
        rotor = DrivenRotor(*generator.normal(scale=100.0, size=3))
        theta, theta_dot = generator.normal(scale=10.0, size=2)
        angles = np.linspace(0.0, 2 * np.pi, 2001)
        gained = rotor.energy(theta, theta_dot) - rotor.energy(angles, 0.0).min()
        pendulum = SimpleNamespace(rotor=rotor, theta=theta, theta_dot=theta_dot)
        assert math.sqrt(2 * gained) <= fastest_rate(pendulum)
