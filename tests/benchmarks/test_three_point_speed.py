"""Cost of the exact three-point motion: a turn manoeuvre to rest, and a hundred of them.

Processor time of one thread, the smallest of a few runs: a busy machine only adds to it.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import pytest

from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import turn_of
from plumbob.analytic.systems.slider_path import arc_stroke, concatenate, fixed
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.analytic.systems.three_points.smoothed_friction import smoothed_motion
from plumbob.tests.support.random_capsules import CHECK
from plumbob.tests.support.random_slides import COAST

MOST = 0.1  # [s], a turn manoeuvre to rest


def cost(action: Callable[[], object], runs: int = 21) -> float:
    """Processor time of `action` [s]."""
    spent = []
    for _ in range(runs):
        begin = time.thread_time()
        action()
        spent.append(time.thread_time() - begin)
    return min(spent)


@pytest.mark.parametrize("epsilon", [0.3, 0.1, 0.03, 0.01, 0.001])
def test_a_turn_to_rest_is_quick(epsilon: float) -> None:
    turn = turn_of(CHECK, 0.12, epsilon)
    assert cost(lambda: three_point_motion(CHECK, turn.path)) <= MOST


def test_a_residual_motion_is_quicker() -> None:
    assert cost(COAST.motion) <= 0.5 * MOST


def test_smoothed_friction_costs_many_times_as_much() -> None:
    exact = cost(COAST.motion)
    time_to_rest = COAST.motion().rest_time
    smoothed = cost(
        lambda: smoothed_motion(COAST.capsule, COAST.path, COAST.state, time_to_rest, 1e-8), 1
    )
    assert smoothed > 5 * exact


def test_evaluating_a_motion_is_cheap() -> None:
    motion = three_point_motion(CHECK, turn_of(CHECK, 0.12, 0.1).path)
    times = np.linspace(0.0, motion.rest_time, 10_000)
    assert cost(lambda: motion.at(times)) <= MOST


def test_repeated_turns_cost_the_same_each_and_stay_exact() -> None:
    """Back and forth fifty times, each to rest: times add up, errors hardly accumulate."""
    drive, half = 4000.0, 0.015
    out, back = arc_stroke(0.12, 0.0, drive, half), arc_stroke(0.12, drive * half**2, -drive, half)
    parts = (out, fixed(out.end, 0.1), back, fixed((0.12, 0.0), 0.1))
    path = concatenate(*(part for _ in range(50) for part in parts))
    assert cost(lambda: three_point_motion(CHECK, path), 1) <= 100 * MOST
    motion = three_point_motion(CHECK, path)
    end = np.array([path.duration])
    fine, coarse = motion.at(end), motion.coarser().at(end)
    assert np.abs(fine.position - coarse.position).max() <= 1e-10
    assert np.abs(fine.heading - coarse.heading).max() <= 1e-10
