"""Cost of the exact three-point motion in reference steps: a turn manoeuvre to rest, and fifty.

Processor time of one thread, turn by turn beside MuJoCo's step of an empty model: a slow spell of
the machine touches both.
"""

import time

import numpy as np
import pytest

from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import turn_of
from plumbob.analytic.systems.slider_path import arc_stroke, concatenate, fixed
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.engines.study.cost import reference_step
from plumbob.tests.support.benchmark_runs import in_turn
from plumbob.tests.support.random_capsules import CHECK
from plumbob.tests.support.random_slides import COAST

MOST = 70_000  # reference steps, a turn manoeuvre to rest: a tenth of a second


def cost(action):
    """Processor time of `action` [s], where no motion is kept that was worked out before."""
    three_point_motion.cache_clear()
    begin = time.thread_time()
    action()
    return time.thread_time() - begin


def _coasted():
    """The segments of a residual motion: it is computed when they are asked for."""
    return COAST.motion().segments


def in_steps(action, turns=11):
    """The cost of `action` in reference steps, turn by turn."""
    rule = reference_step()
    return in_turn(lambda: cost(action), lambda: 1e-9 * rule(), turns)


@pytest.mark.parametrize("epsilon", [0.3, 0.1, 0.03, 0.01, 0.001])
def test_a_turn_to_rest_is_quick(epsilon, hold):
    turn = turn_of(CHECK, 0.12, epsilon)
    turns = in_steps(lambda: three_point_motion(CHECK, turn.path).segments)
    hold(f"exact turn, epsilon {epsilon:g}, over an empty step", turns, most=MOST)


def test_a_residual_motion_is_quicker(hold):
    hold("exact spin over an empty step", in_steps(_coasted), most=0.5 * MOST)


def test_evaluating_a_motion_is_cheap(hold):
    motion = three_point_motion(CHECK, turn_of(CHECK, 0.12, 0.1).path)
    times = np.linspace(0.0, motion.rest_time, 10_000)
    turns = in_steps(lambda: motion.at(times))
    hold("10^4 samples of a turn over an empty step", turns, most=MOST)


def test_repeated_turns_cost_the_same_each_and_stay_exact(hold):
    """Back and forth fifty times, each to rest: times add up, errors hardly accumulate."""
    drive, half = 4000.0, 0.015
    out, back = arc_stroke(0.12, 0.0, drive, half), arc_stroke(0.12, drive * half**2, -drive, half)
    parts = (out, fixed(out.end, 0.1), back, fixed((0.12, 0.0), 0.1))
    paths = [concatenate(*(part for _ in range(n) for part in parts)) for n in (50, 5)]
    motion = three_point_motion(CHECK, paths[0])
    end = np.array([paths[0].duration])
    fine, coarse = motion.at(end), motion.coarser().at(end)
    assert np.abs(fine.position - coarse.position).max() <= 1e-10
    assert np.abs(fine.heading - coarse.heading).max() <= 1e-10
    turns = in_turn(
        lambda: cost(lambda: three_point_motion(CHECK, paths[0]).segments),
        lambda: cost(lambda: three_point_motion(CHECK, paths[1]).segments),
        3,
    )
    hold("fifty exact turns over five", turns, most=15)
