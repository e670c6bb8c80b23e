"""Cost of the pendulum's closed form relative to a Taylor integrator and an explicit Runge-Kutta.

The sides are timed in turn, by processor time, so that a busy machine moves them together.
"""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.systems.cone_pendulum import ConePendulum, cone
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.cost import reference_step
from plumbob.tests.numerics.double_pendulum import double_pendulum
from plumbob.tests.support.benchmark_runs import in_turn
from plumbob.tests.support.high_precision import orbit_of

PENDULUM = ConePendulum(cone(8000.0, 0.3, math.radians(30.0)), 0.0, 0.09, 26.0, 9.8, 0.0, 37.0)
TIMES = np.linspace(0.0, 50.0, 1_000_000)
ROTOR = PENDULUM.motion.rotor


def seconds(run):
    """Processor time [s] of one run."""
    begin = time.thread_time()
    run()
    return time.thread_time() - begin


def solved():
    """The motion with everything it needs to be evaluated at many times."""
    motion = PENDULUM.motion
    fresh = PendulumMotion(motion.potential, motion.inertia, motion.theta, motion.theta_dot)
    assert fresh.table.theta.shape[1] > 0
    return fresh


def right_side(_, state):
    """theta', theta'' by the cheapest arithmetic that Python has for two numbers."""
    theta, rate = state
    sine, cosine = math.sin(theta), math.cos(theta)
    bend = (2 * ROTOR.sin2 * sine + ROTOR.cos) * cosine - ROTOR.sin * sine
    return np.array([rate, bend])


def heyoka_grid(tolerance):
    """A run of heyoka's integrator over the grid, compiled beforehand."""
    hy = pytest.importorskip("heyoka")
    x, v = hy.make_vars("x", "v")
    sine, cosine = hy.sin(x), hy.cos(x)
    bend = (2 * ROTOR.sin2 * sine + ROTOR.cos) * cosine - ROTOR.sin * sine
    integrator = hy.taylor_adaptive([(x, v), (v, bend)], [0.0, 37.0], tol=tolerance)

    def run():
        integrator.time = 0.0
        integrator.state[:] = [0.0, 37.0]
        grid = integrator.propagate_grid(TIMES)[-1][:, 0]
        return grid

    return run


def worst_error(theta):
    """Largest error [rad] of theta on the grid, at some of its points, against 40 digits."""
    picked = np.linspace(0, TIMES.size - 1, 25).astype(int)
    guess = PENDULUM.motion.closed_form.state(TIMES[picked])
    _, _, states = orbit_of(PENDULUM).follow(TIMES[picked].tolist(), list(zip(*guess, strict=True)))
    exact = [state[0] for state in states]
    return max(abs(float(x - y)) for x, y in zip(theta[picked], exact, strict=True))


def sampled():
    """Processor time [s] of the closed form on the grid."""
    return seconds(lambda: PENDULUM.motion.table.angle(TIMES))


@pytest.mark.parametrize("tolerance", [1e-16, 0.0])
def test_a_million_times_against_heyoka(tolerance, hold):
    # Measured: 4 to 8.
    grid = heyoka_grid(tolerance)
    assert worst_error(PENDULUM.motion.table.angle(TIMES)) <= 3e-13
    turns = in_turn(lambda: seconds(grid), sampled, 7)
    hold(f"10^6 samples: heyoka at {tolerance:g} over the closed form", turns, least=3)


def test_a_million_times_against_dop853(hold):
    def integrated():
        span, state = (0.0, 50.0), [0.0, 37.0]
        return seconds(
            lambda: solve_ivp(right_side, span, state, "DOP853", TIMES, rtol=1e-13, atol=1e-13)
        )

    turns = in_turn(integrated, sampled, 3)
    hold("10^6 samples: scipy's DOP853 over the closed form", turns, least=100)


def test_a_late_time_costs_what_an_early_one_does(hold):
    table = PENDULUM.motion.table
    turns = in_turn(
        lambda: seconds(lambda: table.angle(1e9 + TIMES / 50.0)),
        lambda: seconds(lambda: table.angle(TIMES / 50.0)),
    )
    hold("10^6 samples: after 10^9 s over the first second", turns, most=1.2)


def test_building_the_solution_takes_some_hundred_steps(hold):
    # Each turn is the smallest of many: the machine is shared, and interruptions only add.
    solved()
    rule = reference_step()
    turns = in_turn(lambda: min(seconds(solved) for _ in range(20)), lambda: 1e-9 * rule())
    hold("building a closed form over MuJoCo's empty step", turns, most=1000)


def test_a_certified_motion_against_dop853(hold):
    # Measured: 1.6. Two integrations and the linearisation, to 2e-10 rad, beside one to 1e-9 rad.
    system = double_pendulum()

    def certified():
        return seconds(lambda: CertifiedMotion(system).uncertainty(np.array([10.0])))

    def integrated():
        ends, start = (0.0, 10.0), system.start
        return seconds(
            lambda: solve_ivp(system.slope, ends, start, "DOP853", rtol=1e-13, atol=1e-13)
        )

    turns = in_turn(certified, integrated, 5)
    hold("10 s of a double pendulum: certified over scipy's DOP853", turns, most=2)
