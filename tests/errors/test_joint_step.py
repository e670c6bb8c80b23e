"""Theory of Euler's step on a bob with a joint against the step itself, in complex arithmetic."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.errors.smooth_motion.jointed_euler import TERMS, JointedSeries
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.driven_motion import DrivenMotion
from plumbob.tests.support.pendulum_cases import CASES

NAMES = ("theta", "theta_dot", "excess")
TIGHT, SLOW = math.inf, 6.3  # [1/s] at which a joint closes
# for each a duration [s] and two steps [s]: where the fifth term is seen above round-off
RUNS = {TIGHT: (5.0, 2e-3, 1e-3), SLOW: (2.0, 4e-4, 2e-4)}


def stepped(
    rotor: DrivenRotor, theta: float, theta_dot: float, step: float, steps: int, closing: float
) -> Array:
    """theta, theta_dot and the excess of the joint's pull after each step, shape (3, steps + 1)."""
    tight = math.isinf(closing)
    closed = 1.0 if tight else -math.expm1(-closing * step)
    before = theta_dot - step * float(rotor.acceleration(0.0, theta, theta_dot))
    turn = 1j * step * before
    opening = cmath.exp(-turn) * (1 + turn) - 1 if tight else 0j
    x, w, rows = theta, theta_dot, [(theta, theta_dot, 0.0)]
    for n in range(steps):
        push = float(rotor.forcing(n * step)) - rotor.damping_rate * w
        turned = step * w
        x, back = x + turned, cmath.exp(-1j * turned)
        opened = (1 - closed) * back * opening + back * (1 + 1j * turned) - 1
        slack = closed * (opened - back * opening) / step
        pull = (slack.real + w * math.sin(turned)) / step + push * math.sin(turned)
        w = w * math.cos(turned) + slack.imag
        w += step * (push * math.cos(turned) - rotor.sin * math.sin(x))
        opening = opened
        rows.append((x, w, pull - w * w))
    return np.array(rows).T


def left_over(case: str, closing: float, step: float, rotor: DrivenRotor | None = None) -> Array:
    """Largest error after 0, 1 ... TERMS terms of the expansion for `rotor`, (TERMS + 1, 3)."""
    given, (duration, *_) = CASES[case], RUNS[closing]
    start = (given.theta, given.theta_dot)
    steps = round(duration / step)
    kept = np.arange(steps // 20, steps + 1, steps // 20)
    values = stepped(given.rotor, *start, step, steps, closing)[:, kept]
    times = np.minimum(kept * step, duration)
    exact = DrivenMotion(given.rotor, *start, duration).observe(times)
    errors = values - np.stack([exact["theta"], exact["theta_dot"], np.zeros(len(times))])
    predicted = JointedSeries(rotor or given.rotor, *start).at(closing, times)
    left = [np.abs(errors).max(axis=1)]
    for power in range(1, TERMS + 1):
        errors = errors - np.stack([predicted[power][name] for name in NAMES]) * step**power
        left.append(np.abs(errors).max(axis=1))
    return np.array(left)


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("closing", RUNS)
@pytest.mark.parametrize("case", ["free-large", "damped-large", "forced-large", "damped-rotating"])
def test_each_term_removes_one_order(case: str, closing: float) -> None:
    _, coarse, fine = RUNS[closing]
    first, second = left_over(case, closing, coarse), left_over(case, closing, fine)
    # theta rounds at 1e-14; the opening too, and the joint's pull divides that by h^2
    above = second > np.array([1e-12, 1e-11, 1e-15 / fine**2])
    assert above[:2].all()
    for terms in range(1, TERMS + 1):
        # Halving the step divides the remainder by 2^(terms + 1), apart from the next term; after a
        # start in motion, which is accurate to h^3 only, the fourth power may remain.
        orders = np.log2(first[terms] / second[terms])[above[terms]]
        assert (orders > min(terms, TERMS - 1) + 0.5).all(), (terms, orders)


@pytest.mark.parametrize("closing", RUNS)
def test_a_coefficient_error_of_a_thousandth_is_detected(closing: float) -> None:
    # three terms leave 1e-6 of the error or less; a damping rate wrong by 0.1 %, 1e-4
    given, step = CASES["forced-large"].rotor, RUNS[closing][2]
    off = replace(given, damping_rate=given.damping_rate * (1 + 1e-3))
    right, wrong = (left_over("forced-large", closing, step, r) for r in (given, off))
    assert wrong[3][0] > 10 * right[3][0]


def test_later_times_are_computed_anew() -> None:
    given = CASES["free-large"]
    series = JointedSeries(given.rotor, given.theta, given.theta_dot)
    early, late = np.array([0.5, 1.0]), np.array([0.5, 5.0])
    first = series.at(TIGHT, early)[1]["theta"][0]
    again = series.at(TIGHT, late)[1]["theta"][0]
    assert first == pytest.approx(again, rel=1e-9)
