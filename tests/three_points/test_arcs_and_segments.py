"""Plans along arbitrary arcs of the circle and segments of any two lines, exact and in MuJoCo."""

import math
from functools import cache

import numpy as np
import pytest

from plumbob.models.registry import scene
from plumbob.models.tripod_capsule.plan import requested_plan

REACHED = 1e-11  # the plan is exact: the errors of the reference remain
SEED = 27
TASKS = range(10)


@cache
def task(number):
    """A random pose, an arc of 0.15 to 2.5 rad either way round, and segments of 3 to 10 cm."""
    rng = np.random.default_rng([SEED, number])
    first = rng.uniform(-math.pi, math.pi)
    extent = rng.uniform(0.15, 2.5) * rng.choice([-1, 1])
    line = rng.uniform(-math.pi, math.pi)
    lows = rng.uniform(-0.1, 0.06, 2)
    lengths = rng.uniform(0.03, 0.1, 2)
    lines = zip((line, line + rng.uniform(0.4, 2.7)), lows, lengths, strict=True)
    return {
        "to": (*rng.uniform(-0.05, 0.05, 2), rng.uniform(-0.6, 0.6)),
        "track": "curve",
        "arc": (first, first + extent),
        "segments": tuple((side, low, low + length) for side, low, length in lines),
    }


def asked(number):
    """The plan of a task."""
    return requested_plan(scene("capsule-plan", task(number)).parameters)


@pytest.mark.rare(keep=4)
@pytest.mark.long
@pytest.mark.parametrize("number", TASKS)
def test_a_pose_is_reached_along_any_arc_and_segments(number):
    made = asked(number)
    given = task(number)
    assert max(made.error) <= REACHED
    assert made.path.end == pytest.approx((0.0, 0.0), abs=1e-16)
    assert made.turns > 0 < made.lines
    low, high = sorted(given["arc"])
    lines = np.array(given["segments"])
    for one in made.manoeuvres:
        place = one.path.kinematics(np.linspace(0.0, one.duration, 9))[0] @ [1.0, 1j]
        if one.kind == "turn" or "radius" in one.parameters:  # or a slow return round the arc
            on = (np.angle(place) - low + 1e-9) % (2 * math.pi) - 1e-9
            assert np.abs(np.abs(place) - made.limits.radius).max() <= 1e-12
            assert on.max() <= high - low + 1e-9
        if one.kind == "line":
            along = place[:, None] * np.exp(-1j * lines[:, 0])
            off = np.maximum(lines[:, 1] - along.real, along.real - lines[:, 2])
            beside = np.maximum(np.abs(along.imag), off).max(axis=0)
            assert beside.min() <= 1e-12
