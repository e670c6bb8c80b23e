"""The uncertainty of the exact rotation at random symmetric and nearly symmetric bodies."""

import numpy as np
import pytest

from plumbob.analytic.systems.free_body.problem import FreeBody
from plumbob.analytic.systems.free_body.rotation import ANGULAR_VELOCITY_NAMES, ATTITUDE
from plumbob.tests.support.random_bodies import drawn, exact

MOST = 0.7  # of what is stated: the rest is for bodies that were not drawn
LEAST = 0.02  # of what is stated, by the median body: with less it would say nothing
SIZE = 40  # bodies in a block


def used(seed):
    """The largest part that a random body's error has in what is stated of it."""
    body = drawn(seed)
    motion = FreeBody(*body.moments, body.rates)
    times = np.array(body.times)
    observed = motion.observe(times)
    stated = motion.uncertainty(times)
    states = exact(body.moments, body.rates, body.times)
    errors = [
        abs(row - observed[name])
        for name, row in zip((*ANGULAR_VELOCITY_NAMES, *ATTITUDE), states, strict=True)
    ]
    return max(
        float(max(error / stated[name]))
        for name, error in zip((*ANGULAR_VELOCITY_NAMES, *ATTITUDE), errors, strict=True)
    )


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("block", range(6))
def test_the_error_is_a_part_of_what_is_stated(block):
    parts = [used(seed) for seed in range(SIZE * block, SIZE * (block + 1))]
    assert max(parts) <= MOST, parts.index(max(parts)) + SIZE * block
    assert np.median(parts) >= LEAST


@pytest.mark.parametrize(
    ("moments", "rates", "time", "attitude"),
    [
        ((1.0, 2.0, 2.0), (1e-6, 2.0, 3.0), 1.0, "-0.229904264251192"),
        ((1.0, 2.0, 2.0), (1e-15, 0.0, 3.0), 1e-3, "0.99999887500021093748"),
    ],
)
def test_a_symmetric_body_that_hardly_spins(moments, rates, time, attitude):
    """It turns evenly about the angular momentum, here across the axis: by 3e-3 rad in 1 ms."""
    found = FreeBody(*moments, rates).observe(np.array([time]))["attitude_w"][0]
    assert abs(found - float(attitude)) < 1e-15


if __name__ == "__main__":
    parts = np.array([used(seed) for seed in range(2000)])
    print(
        f"2000 bodies: at most {parts.max():.2f} of what is stated, median {np.median(parts):.3f}"
    )
