"""A body that turns about an axis of its own, or any axis of a sphere, with 40 digits."""

import numpy as np
import pytest
from mpmath import mp

from plumbob.analytic.systems.free_body.problem import FreeBody
from plumbob.analytic.systems.free_body.rotation import ANGULAR_VELOCITY_NAMES, ATTITUDE

BODIES = {
    "a sphere": ((2.0, 2.0, 2.0), (1.0, -2.0, 2.5)),
    "about the middle axis": ((1.0, 2.0, 2.5), (0.0, 3.0, 0.0)),
    "about the largest": ((1.0, 2.0, 2.5), (0.0, 0.0, -0.7)),
}


def turned(rates, time):
    """The attitude, cos and the axis times sin of half the angle."""
    speed = mp.sqrt(sum(rate**2 for rate in rates))
    half = speed * time / 2
    return [mp.cos(half), *(rate / speed * mp.sin(half) for rate in rates)]


@pytest.mark.parametrize("name", BODIES)
def test_40_digits(name):
    moments, start = BODIES[name]
    body = FreeBody(*moments, start)
    times = np.array([0.3, 7.0, 1e4])
    observed, doubt = body.observe(times), body.uncertainty(times)
    with mp.workdps(40):
        rates = [mp.mpf(rate) for rate in start]
        for k, time in enumerate(map(mp.mpf, times)):
            for n, value in zip(
                (*ANGULAR_VELOCITY_NAMES, *ATTITUDE),
                (*rates, *turned(rates, time)),
                strict=True,
            ):
                assert abs(value - mp.mpf(observed[n][k])) <= doubt[n][k], n
    assert max(value[0] for value in doubt.values()) < 1e-14
