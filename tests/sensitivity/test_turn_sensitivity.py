"""Small mistakes in a turn manoeuvre are detected, in its formulas and in its exact motion."""

from __future__ import annotations

from dataclasses import replace

import pytest

from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre, turn_of
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.tests.support.random_capsules import CHECK
from plumbob.tests.support.random_slides import moved_support, pose


def turned(turn):
    """The exact heading at 2 tau [rad]."""
    return float(pose(three_point_motion(turn.capsule, turn.path), 2 * turn.half_time)[2])


@pytest.mark.parametrize(
    "wrong",
    [replace(CHECK, friction=CHECK.friction * (1 + 1e-4)), moved_support(CHECK, 1e-4)],
)
def test_sensitivity_of_the_check_values(wrong):
    """1e-4 of the friction, or of a support's arm, is detected at 1e-8."""
    turn = turn_of(CHECK, 0.12, 0.1)
    other = TurnManoeuvre(wrong, 0.12, turn.angular_acceleration, turn.half_time)
    assert abs(turned(other) - turned(turn)) > 1e-8
    coefficient = turn.correction.at_stop.heading
    assert abs(other.correction.at_stop.heading / coefficient - 1) > 5e-6
