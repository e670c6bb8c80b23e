"""Short pivots of a body whose load only just exceeds the friction limit."""

import math

import pytest

from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.planner.manoeuvre import slow_arc
from plumbob.analytic.systems.slider_path import ArcPiece, arc
from plumbob.analytic.systems.three_points.balance import balance
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.tests.support.random_capsules import CHECK
from plumbob.tests.support.random_slides import ending, pose

OTHER = Capsule(1.3, 0.4, 0.03, ((0.22, 0.03), (-0.09, 0.17), (-0.12, -0.14)), 0.25, 9.81)
WHOLE = slow_arc(CHECK, 0.12, 0.3, 2.4, 1.0), slow_arc(OTHER, 0.12, 0.3, 2.4, 1.0)


def accelerated(number, excess):
    """A slow arc at the friction limit, with accelerations larger by the fraction `excess`."""
    pieces = [p for p in WHOLE[number].path.pieces if isinstance(p, ArcPiece)]
    drives = [piece.acceleration * (1.0 + excess) for piece in pieces]
    return arc(0.12, 0.3, drives, [p.duration / math.sqrt(1.0 + excess) for p in pieces])


def heading(number, excess):
    motion = three_point_motion((CHECK, OTHER)[number], accelerated(number, excess))
    assert [event.mode for event in motion.events] == ["rest", "pivot", "rest"]
    # As in every slide, although the forces of the pivot nearly balance.
    found = balance(motion)
    assert max(found.energy, found.momentum, found.angular_momentum) <= 1e-11
    return float(pose(motion, ending(motion))[2])


@pytest.mark.parametrize("number", [0, 1])
def test_a_pivot_shorter_than_a_sample_of_its_element(number):
    """The angle grows as the cube of the excess: the load exceeds its limit by the excess for a
    time proportional to it, which gives a rate of its square for a similar time."""
    small, large = heading(number, 1e-4), heading(number, 1e-3)
    assert small > 1e-14  # a hundred roundings of the inputs
    assert large / small == pytest.approx(1000.0, rel=0.01)  # the next power of the excess
