"""The series in the step of a bob with a joint beside the step itself, in plain numbers, which the
engine's own steps follow to rounding (test_stepped_rotor)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from plumbob.analytic.errors.smooth_motion.jointed_euler import TERMS
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.models.registry import case_of, scene

NAMES = ("theta", "theta_dot", "tension")
TIGHT, SLOW = math.inf, 6.3  # [1/s] at which a joint closes
# for each a duration [s] and two steps [s]: where the fifth term is seen above round-off
RUNS = {TIGHT: (5.0, 2e-3, 1e-3), SLOW: (2.0, 4e-4, 2e-4)}


def left_over(name, closing, step, wrong=0.0):
    """Largest error after 0, 1 ... TERMS terms of the expansion, (TERMS + 1, 3), whose damping rate
    is wrong by a relative `wrong`."""
    right = scene(f"simple-pendulum/{name}")
    other = scene(right.name, {"damping_rate": right.parameters["damping_rate"] * (1 + wrong)})
    scheme = Scheme(EULER, position_first=True, joint_closing_rate=closing)
    steps = round(RUNS[closing][0] / step)
    times = np.arange(0, steps + 1, steps // 20, dtype=np.float64) * step
    stepped = case_of(right).errors.at_step(scheme, step, times).errors
    predicted = case_of(other).errors.series(scheme, times)
    errors = np.stack([stepped[name] for name in NAMES])[:, 1:]
    left = [np.abs(errors).max(axis=1)]
    for power in range(1, TERMS + 1):
        errors = errors - np.stack([predicted[power][name] for name in NAMES])[:, 1:] * step**power
        left.append(np.abs(errors).max(axis=1))
    return np.array(left)


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("closing", RUNS)
@pytest.mark.parametrize("name", ["free-large", "damped-large", "forced-large", "damped-rotating"])
def test_each_term_removes_one_order(name, closing):
    _, coarse, fine = RUNS[closing]
    first, second = left_over(name, closing, coarse), left_over(name, closing, fine)
    # theta rounds at 1e-14; the opening too, and the joint's pull divides that by h^2
    above = second > np.array([1e-12, 1e-11, 1e-15 / fine**2])
    assert above[:2].all()
    for terms in range(1, TERMS + 1):
        # Halving the step divides the remainder by 2^(terms + 1), apart from the next term; after a
        # start in motion, which is accurate to h^3 only, the fourth power may remain.
        orders = np.log2(first[terms] / second[terms])[above[terms]]
        assert (orders > min(terms, TERMS - 1) + 0.5).all(), (terms, orders)


@pytest.mark.parametrize("closing", RUNS)
def test_a_coefficient_error_of_a_thousandth_is_detected(closing):
    # three terms leave 1e-6 of the error or less; a damping rate wrong by 0.1 %, 1e-4
    step = RUNS[closing][2]
    right, wrong = (left_over("forced-large", closing, step, by) for by in (0.0, 1e-3))
    assert wrong[3][0] > 10 * right[3][0]


def test_later_times_are_computed_anew():
    series = case_of(scene("simple-pendulum/free-large")).errors.series
    scheme = Scheme(EULER, position_first=True, joint_closing_rate=TIGHT)
    first, again = (series(scheme, np.array([0.5, end]))[1]["theta"][0] for end in (1.0, 5.0))
    assert first == pytest.approx(again, rel=1e-9)
