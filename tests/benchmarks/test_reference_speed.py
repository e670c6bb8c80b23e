"""Cost of the pendulum's closed form relative to a Taylor integrator and an explicit Runge-Kutta.

The sides are timed in turn, by processor time, so that a busy machine moves them together.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbob.analytic.numerics.elliptic.orbit_table import orbit_table
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.cone_pendulum import ConePendulum, cone
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.tests.support.high_precision import orbit_of

PENDULUM = ConePendulum(cone(8000.0, 0.3, math.radians(30.0)), 0.0, 0.09, 26.0, 9.8, 0.0, 37.0)
TIMES = np.linspace(0.0, 50.0, 1_000_000)
ROTOR = PENDULUM.motion.rotor


def seconds(run: Callable[[], Any]) -> float:
    """Processor time [s] of one run."""
    begin = time.thread_time()
    run()
    return time.thread_time() - begin


def in_turn(runs: dict[str, Callable[[], Any]], rounds: int) -> dict[str, float]:
    """Median processor time [s] of each; they are timed alternately."""
    taken = [{name: seconds(run) for name, run in runs.items()} for _ in range(rounds)]
    return {name: statistics.median(row[name] for row in taken) for name in runs}


def solved() -> PendulumMotion:
    """The motion with everything it needs to be evaluated at many times."""
    motion = PENDULUM.motion
    fresh = PendulumMotion(motion.potential, motion.inertia, motion.theta, motion.theta_dot)
    assert fresh.table.theta.shape[1] > 0
    return fresh


def right_side(_: float, state: Array) -> Array:
    """theta', theta'' by the cheapest arithmetic that Python has for two numbers."""
    theta, rate = state
    sine, cosine = math.sin(theta), math.cos(theta)
    bend = (2 * ROTOR.sin2 * sine + ROTOR.cos) * cosine - ROTOR.sin * sine
    return np.array([rate, bend])


def heyoka_grid(tolerance: float) -> Callable[[], Array]:
    """A run of heyoka's integrator over the grid, compiled beforehand."""
    hy = pytest.importorskip("heyoka")
    x, v = hy.make_vars("x", "v")
    sine, cosine = hy.sin(x), hy.cos(x)
    bend = (2 * ROTOR.sin2 * sine + ROTOR.cos) * cosine - ROTOR.sin * sine
    integrator = hy.taylor_adaptive([(x, v), (v, bend)], [0.0, 37.0], tol=tolerance)

    def run() -> Array:
        integrator.time = 0.0
        integrator.state[:] = [0.0, 37.0]
        grid: Array = integrator.propagate_grid(TIMES)[-1][:, 0]
        return grid

    return run


def worst_error(theta: Array) -> float:
    """Largest error [rad] of theta on the grid, at some of its points, against 40 digits."""
    picked = np.linspace(0, TIMES.size - 1, 25).astype(int)
    guess = PENDULUM.motion.closed_form.state(TIMES[picked])
    _, _, states = orbit_of(PENDULUM).follow(TIMES[picked].tolist(), list(zip(*guess, strict=True)))
    exact = [state[0] for state in states]
    return max(abs(float(x - y)) for x, y in zip(theta[picked], exact, strict=True))


def test_a_million_times_against_heyoka() -> None:
    # Required: 3; measured: 4 to 8.
    table = PENDULUM.motion.table
    grids = {f"heyoka, tol {tol:g}": heyoka_grid(tol) for tol in (1e-16, 0.0)}
    found = in_turn({"closed form": lambda: table.angle(TIMES), **grids}, rounds=7)
    error = worst_error(table.angle(TIMES))
    for name, run in grids.items():
        print(f"\n{name}: {found[name] * 1e3:.1f} ms, error {worst_error(run()):.1e}", end="")
    print(f"\nclosed form: {found['closed form'] * 1e3:.1f} ms, error {error:.1e} rad")
    assert error <= 3e-13
    assert min(found[name] for name in grids) >= 3 * found["closed form"]


def test_a_million_times_against_dop853() -> None:
    # Required: 100.
    table = PENDULUM.motion.table

    def integrated() -> Any:
        return solve_ivp(
            right_side, (0.0, 50.0), [0.0, 37.0], "DOP853", TIMES, rtol=1e-13, atol=1e-13
        )

    slow = seconds(integrated)
    fast = statistics.median(seconds(lambda: table.angle(TIMES)) for _ in range(7))
    print(f"\nDOP853: {slow:.2f} s, closed form {fast * 1e3:.1f} ms: {slow / fast:.0f} times")
    assert slow >= 100 * fast


def test_a_late_time_costs_what_an_early_one_does() -> None:
    table = PENDULUM.motion.table
    found = in_turn(
        {
            "first second": lambda: table.angle(TIMES / 50.0),
            "a second after 10^9 s": lambda: table.angle(1e9 + TIMES / 50.0),
        },
        rounds=7,
    )
    print(f"\n{found}")
    assert found["a second after 10^9 s"] <= 1.2 * found["first second"]


def test_building_the_solution_takes_a_millisecond() -> None:
    # The smallest of many: the machine is shared, and interruptions only add.
    solved()
    whole = min(seconds(solved) for _ in range(200))
    motion = PENDULUM.motion.closed_form
    table = min(seconds(lambda: orbit_table(motion)) for _ in range(200))
    print(f"\nbuilding: {whole * 1e3:.2f} ms, the table's part {table * 1e3:.2f} ms")
    assert whole <= 1e-3
