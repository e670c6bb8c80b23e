"""Cost of the pendulum's closed form relative to an explicit Runge-Kutta method.

The sides are timed in turn, by processor time, so that a busy machine moves them together.
"""

import math
import time

import numpy as np
from scipy.integrate import solve_ivp

from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.systems.cone_pendulum import ConePendulum, solid_cone
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.cost import reference_step
from plumbob.tests.numerics.double_pendulum import double_pendulum
from plumbob.tests.support.benchmark_runs import in_turn

PENDULUM = ConePendulum(
    solid_cone(8000.0, 0.3, math.radians(30.0)), 0.0, 0.09, 26.0, 9.8, 0.0, 37.0
)
TIMES = np.linspace(0.0, 50.0, 1_000_000)
ROTOR = PENDULUM.motion.rotor


def seconds(run):
    """Processor time [s] of one run."""
    begin = time.thread_time()
    run()
    return time.thread_time() - begin


def solved():
    """The motion with the constants of its closed form."""
    motion = PENDULUM.motion
    fresh = PendulumMotion(motion.potential, motion.inertia, motion.theta, motion.theta_dot)
    assert fresh.closed_form.period > 0.0
    return fresh


def right_side(_, state):
    """theta', theta'' by the cheapest arithmetic that Python has for two numbers."""
    theta, rate = state
    sine = math.sin(theta)
    cosine = math.cos(theta)
    bend = (2 * ROTOR.sin2 * sine + ROTOR.cos) * cosine - ROTOR.sin * sine
    return np.array([rate, bend])


def sampled(times=TIMES):
    """Processor time [s] of the closed form on the grid, or at other `times` [s]."""
    return seconds(lambda: solved().state(times))


def test_a_million_times_against_dop853(hold):
    def integrated():
        span = (0.0, 50.0)
        state = [0.0, 37.0]
        return seconds(
            lambda: solve_ivp(right_side, span, state, "DOP853", TIMES, rtol=1e-13, atol=1e-13)
        )

    turns = in_turn(integrated, sampled, 3)
    hold("10^6 samples: scipy's DOP853 over the closed form", turns, least=50)


def test_a_late_time_costs_what_an_early_one_does(hold):
    turns = in_turn(lambda: sampled(1e9 + TIMES / 50.0), lambda: sampled(TIMES / 50.0))
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
        ends = (0.0, 10.0)
        start = system.start
        return seconds(
            lambda: solve_ivp(system.slope, ends, start, "DOP853", rtol=1e-13, atol=1e-13)
        )

    turns = in_turn(certified, integrated, 5)
    hold("10 s of a double pendulum: certified over scipy's DOP853", turns, most=2)
