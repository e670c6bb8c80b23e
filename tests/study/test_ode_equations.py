"""ODE solvers on equations of any number of coordinates: drag, and motions that diverge."""

import math

import numpy as np
import pytest

from plumbob.engines.adapters.equation import Equation
from plumbob.engines.adapters.integrators import fixed_steps
from plumbob.engines.adapters.ode import ENGINE
from plumbob.engines.adapters.ode.simulation import SOLVERS, adaptive

FIXED = [method for method in ENGINE.methods if method.control == "step"]
ADAPTIVE = [method for method in ENGINE.methods if method.control == "tolerance"]
GRAVITY = 9.81  # [m/s^2]
DRAG = 0.6  # [1/s]
LAUNCH = np.array([3.0, 5.0])  # [m/s]


@pytest.mark.parametrize("method", FIXED, ids=lambda method: method.name)
def test_a_declared_damping_rate_gives_the_same_steps(method):
    # a body thrown in a plane under linear drag: leapfrog's implicit half kick is solved in closed
    # form or by iteration, to the rounding of 200 steps
    def acceleration(time, place, rate):
        return np.array([0.0, -GRAVITY]) - DRAG * rate

    ends = []
    for declared in (DRAG, None):
        names = {"names": ("x", "z"), "rate_names": ("velocity_x", "velocity_z")}
        start = np.zeros(2), LAUNCH, 20.0
        equation = Equation(acceleration, *start, damping_rate=declared, **names)
        run = fixed_steps(equation, method.scheme.integrator, 2.0, 0.01).run()
        ends.append([values[-1] for values in run.observables.values()])
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-13)


def exploding(time, place, rate):
    """theta'' = 6 theta^2, whose solution 1/(1 - t)^2 from (1, 2) ends at t = 1."""
    return 6 * place * place


def sine_of_much(time, place, rate):
    """A force that overflows, for which math.sin then raises."""
    return math.sin(place) + 1e3 * place


DIVERGING = {
    "one": Equation(exploding, 1.0, 2.0, 10.0),
    "raises": Equation(sine_of_much, 1.0, 2.0, 10.0),
    # arrays overflow without an exception, and numpy's warnings about it are switched off
    "two": Equation(
        exploding, np.ones(2), 2 * np.ones(2), 10.0, names=("x", "z"), rate_names=("u", "w")
    ),
}


@pytest.mark.long(keep=6)
@pytest.mark.parametrize("kind", DIVERGING)
@pytest.mark.parametrize("method", ENGINE.methods, ids=lambda method: method.name)
def test_divergence_is_a_result(method, kind):
    equation = DIVERGING[kind]
    if method in FIXED:
        simulation = fixed_steps(equation, method.scheme.integrator, 30.0, 1e-3)
        assert kind != "raises" or simulation.stepped(1.0).steps == 0  # nothing to time
    else:
        solver = SOLVERS[method.settings["method"]]
        simulation = adaptive(equation, solver, 1e-6, 30.0)
    trajectory = simulation.run()
    assert len(trajectory.times) > 1
    assert (trajectory.times < trajectory.diverged_at).all() or method in ADAPTIVE
    for values in trajectory.observables.values():
        assert len(values) == len(trajectory.times)
        assert np.isfinite(values).all()
