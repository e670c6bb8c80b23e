"""The platform's rate from which there are four equilibria: counted on both sides of it."""

import math

import numpy as np
import pytest

from plumbob.analytic.systems.cone_pendulum import ConePendulum, HungBody, solid_cone

STEEL = solid_cone(8000.0, 0.3, math.radians(30.0))
# of radius 0.5 m, 0.1 m below the pivot: its largest moment is along its axis
ACROSS = 4.0 * (0.5**2 / 4.0 + 0.1**2)
DISC = HungBody(4.0, 0.1, ACROSS, ACROSS, 4.0 * 0.5**2 / 2.0)
NEAR = 1e-6  # relative: two equilibria that are born are then some 1e-3 rad apart
ANGLES = np.linspace(-math.pi, math.pi, 200_001)


def equilibria(pendulum, rate):
    """The number of zeros of the torque of the weight and of the centrifugal forces, over a turn.
    A mass element at (y, z) from the pivot is pulled outward by its distance from the platform's
    axis times the rate squared."""
    body, square = pendulum.body, rate**2
    arm = body.mass * body.com_distance
    spread = body.inertia_y - body.inertia_z  # integral of z^2 less y^2 over the mass
    sine, cosine = np.sin(ANGLES), np.cos(ANGLES)
    torque = square * cosine * (spread * sine + arm * pendulum.pivot_y)
    torque -= arm * pendulum.gravity * sine
    return int(np.count_nonzero(np.diff(np.sign(torque)) != 0))


@pytest.mark.parametrize("pivot", [0.01, 0.03, -0.02])
@pytest.mark.parametrize("flat", [False, True])
def test_two_equilibria_below_and_four_above(pivot, flat):
    body = DISC if flat else STEEL
    pendulum = ConePendulum(body, 0.0, pivot, 0.0, 9.8, 0.0, 1.0)
    rate = pendulum.saddle_node_rate
    assert [equilibria(pendulum, rate * (1 + side * NEAR)) for side in (-1, 1)] == [2, 4]


def test_far_out_there_are_never_four():
    pendulum = ConePendulum(STEEL, 0.0, 1.0, 0.0, 9.8, 0.0, 1.0)
    assert pendulum.saddle_node_rate == math.inf
    assert {equilibria(pendulum, rate) for rate in (1.0, 10.0, 1e3, 1e6)} == {2}
