"""The ODE solvers on the cone pendulum and on user equations: error, order, divergence."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import lu_factor, lu_solve

from plumbob.analytic.errors.smooth_motion.global_error import leading_error
from plumbob.analytic.errors.smooth_motion.pendulum_errors import pendulum_errors
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.taylor_series import integrate
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.systems.cone_pendulum import cone
from plumbob.engines.adapters.divergence import possible_speed
from plumbob.engines.adapters.mujoco import ENGINE as MUJOCO
from plumbob.engines.adapters.ode import ENGINE, prepare
from plumbob.engines.adapters.ode.equation import Equation
from plumbob.engines.adapters.ode.integrators import integrator
from plumbob.engines.adapters.ode.simulation import (
    AdaptiveSimulation,
    FixedStepSimulation,
    solved,
)
from plumbob.engines.method import Unsupported
from plumbob.tests.support.cone_scene import DEFAULT, SYSTEM, THETA, THETA_DOT, scene

METHODS = {method.name: method for method in ENGINE.methods}
FIXED = [method for method in ENGINE.methods if method.control == "step"]
ADAPTIVE = [method for method in ENGINE.methods if method.control == "tolerance"]
END = np.array([0.5])


def advance(method):
    """The integrator of a method with a fixed step."""
    return integrator(method.scheme.integrator)


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

    simulation = prepare(SYSTEM.case(scene()), METHODS["ode/dop853"], 1e-6)
    assert isinstance(simulation, AdaptiveSimulation)
    replace(simulation, solver=Recorder).run()
    speed = possible_speed(DEFAULT.motion.rotor, DEFAULT.theta_dot)
    assert speed > 37.0
    assert asked == pytest.approx([1e-6, 1e-6, 1e-6 * speed], rel=1e-12)


@pytest.mark.parametrize(
    ("name", "step", "tolerance"),
    [
        ("ode/rk4", 2.5e-5, 5e-13),  # round-off of 20 000 steps at theta = 20
        ("ode/dop853", 1e-13, 1e-11),  # its tolerance a step, accumulated over 150
        ("ode/radau", 1e-11, 2e-12),  # of fifth order, it needs small steps, and its error is less
        ("ode/lsoda", 1e-13, 1e-10),  # erratic: 2e-11 here, ten times that at 3e-13
    ],
)
def test_solver_reaches_the_exact_motion(name, step, tolerance):
    trajectory = run(METHODS[name], step)
    exact = DEFAULT.motion.observe(trajectory.times)
    assert np.abs(trajectory.observables["theta"] - exact["theta"]).max() < tolerance
    speed = np.abs(trajectory.observables["theta_dot"] - exact["theta_dot"]).max()
    assert speed < 20 * tolerance  # theta_dot changes by 20 to 30 times what theta does, a second
    assert trajectory.observables["theta"][-1] == pytest.approx(THETA, abs=tolerance)
    assert trajectory.observables["theta_dot"][-1] == pytest.approx(THETA_DOT, abs=20 * tolerance)


@pytest.mark.parametrize(
    ("name", "first", "power"),
    [("ode/euler", 500, 1), ("ode/leapfrog", 250, 2), ("ode/rk4", 200, 4)],
)
def test_order_and_leading_coefficients(name, first, power):
    # remainder after two terms, at the coarsest step: 0.04 %, 0.01 % and 0.6 %
    method = METHODS[name]
    steps = np.array([0.5 / (first * 2**n) for n in range(5)])
    errors = np.array([error(method, float(step)) for step in steps])
    terms = pendulum_errors(DEFAULT.motion).series(method.scheme, END)
    wanted = sum(float(values["theta"][0]) * steps**p for p, values in terms.items())
    np.testing.assert_allclose(errors, wanted, rtol=0.01)
    slope = float(np.polyfit(np.log(steps), np.log(np.abs(errors)), 1)[0])
    assert method.order == power
    if name == "ode/rk4":  # C5/C4 is 8900/s: both terms show, and the slope lies between
        assert 4.5 < slope < 4.95
    else:
        assert slope == pytest.approx(power, abs=0.01)


@pytest.mark.parametrize(("ours", "theirs"), [("euler", "euler"), ("rk4", "rk4")])
def test_mujoco_takes_the_same_steps(ours, theirs):
    # the same scheme on the same equation in two programs: they differ by 500 steps of round-off
    other = next(method for method in MUJOCO.methods if method.name == f"mujoco/{theirs}")
    engine = MUJOCO.prepare(SYSTEM.case(scene()), other, 1e-3).run()
    solver = run(METHODS[f"ode/{ours}"], 1e-3)
    np.testing.assert_allclose(
        solver.observables["theta"], engine.observables["theta"], rtol=0, atol=2e-12
    )


WIDE = cone(8000.0, 0.1, 2.6)
SKEW = replace(DEFAULT.body, inertia_y=DEFAULT.body.inertia_y + 0.03)


@pytest.mark.parametrize(
    "given",
    [{"platform_rate": 0.0, "theta_dot": 13.0}, {"body": WIDE}, {"body": SKEW}, {"excess": 1e-3}],
    ids=["still", "wide", "skew", "excess"],
)
def test_other_parameters_follow_the_closed_form(given):
    # DOP853 as above; near the separatrix (rate 25/s) an error grows by e^(25 t) in passing it
    trajectory = run(METHODS["ode/dop853"], 1e-13, **given)
    exact = replace(DEFAULT, **given).motion.observe(trajectory.times)["theta"]
    grown = 100.0 if "excess" in given else 1.0
    assert np.abs(trajectory.observables["theta"] - exact).max() < 1e-11 * grown


@pytest.mark.parametrize(
    "changed",
    [
        {"gravity": 9.8 * (1 + 1e-6)},
        {"platform_rate": 26.0 * (1 + 1e-6)},
        {"theta_dot": 37.0 * (1 + 1e-9)},
        {"pivot_y": 0.09 * (1 + 1e-8)},
    ],
    ids=lambda changed: next(iter(changed)),
)
def test_a_small_change_is_seen(changed):
    assert abs(error(METHODS["ode/dop853"], 1e-13, **changed)) > 1e-11
    assert abs(error(METHODS["ode/rk4"], 2.5e-5, **changed)) > 5e-13


def driven(rotor, theta, theta_dot):
    """A rotor of any kind as an equation of motion."""

    def acceleration(t, x, v):
        return float(rotor.acceleration(t, x, v))

    return Equation(acceleration, theta, theta_dot, 10.0, damping_rate=rotor.damping_rate)


@pytest.mark.parametrize("method", FIXED, ids=lambda method: method.name)
def test_damping_and_forcing_are_as_predicted(method):
    # first two terms of the error, as above; here time and damping both matter
    rotor = DrivenRotor(
        sin=9.8, damping_rate=0.5, forcing_amplitude=1.5, forcing_frequency=2.8, forcing_phase=0.3
    )
    end = np.array([4.0])
    exact = integrate(rotor, 0.7, 1.0, 4.0).at(end)[0][0]
    terms = leading_error(rotor, 0.7, 1.0, end, method.scheme)
    for steps in (800, 1600):
        equation, step = driven(rotor, 0.7, 1.0), 4.0 / steps
        simulation = FixedStepSimulation(equation, advance(method), steps, step, 0.0)
        found = simulation.run().observables["theta"][-1] - exact
        wanted = sum(float(values["theta"][0]) * step**p for p, values in terms.items())
        assert found == pytest.approx(wanted, rel=0.01, abs=1e-13)


@pytest.mark.parametrize("method", FIXED, ids=lambda method: method.name)
def test_a_step_far_too_large_is_a_divergence(method):
    # the torque is bounded, so one step of half a second exceeds any speed the body can have
    trajectory = run(method, 0.5, 200.0)
    assert trajectory.diverged_at is not None
    assert np.abs(trajectory.observables["theta_dot"]).max() < 620.0


def test_no_motion_exceeds_the_speed_that_limits_are_based_on():
    generator = np.random.default_rng(1)
    for _ in range(30):
        rotor = DrivenRotor(*generator.normal(scale=100.0, size=3))
        theta, theta_dot = generator.normal(scale=10.0, size=2)
        angles = np.linspace(0.0, 2 * np.pi, 2001)
        gained = rotor.energy(theta, theta_dot) - rotor.energy(angles, 0.0).min()
        assert math.sqrt(2 * gained) <= possible_speed(rotor, theta_dot)


@pytest.mark.parametrize("step", [0.0, -1.0, float("nan"), 1.0, 1e-15])
@pytest.mark.parametrize("method", [*FIXED, *ADAPTIVE], ids=lambda method: method.name)
def test_a_step_or_tolerance_that_cannot_be_is_refused(method, step):
    with pytest.raises(ParameterError, match=r"^step = .*: must be [^\n]*$"):
        prepare(SYSTEM.case(scene()), method, step)


def test_a_system_without_equation_is_unsupported():
    other = replace(SYSTEM, name="spring-mattress", family="spring_mattress")
    with pytest.raises(Unsupported, match="no builder for spring-mattress"):
        prepare(other.case(scene()), FIXED[0], 1e-3)


def test_the_linear_systems_of_a_run_are_solved_to_the_bit_as_scipy_does():
    random = np.random.default_rng(5)
    for dtype in (float, complex):
        for size in (2, 7):
            factors = lu_factor(random.normal(size=(size, size)).astype(dtype) + 0.5)
            right = random.normal(size=size).astype(dtype)
            expected = lu_solve(factors, right)
            assert np.array_equal(solved(factors, right.copy()), expected)
            right[0] = np.inf
            with pytest.raises(ValueError, match="infs or NaNs"):
                solved(factors, right)
