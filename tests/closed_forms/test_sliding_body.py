"""A body that slides on points without turning: its loads exist where the hull says so."""

import math

import numpy as np
import pytest
from scipy.optimize import linprog

from plumbob.analytic.systems.sliding_body import Stance, stopping_distance

FRICTION, GRAVITY, MASS = 0.3, 9.81, 2.0


def stance(seed):
    random = np.random.default_rng(seed)
    count = int(random.integers(3, 9))
    return Stance(random.normal(size=(count, 2)), float(random.uniform(0.1, 3.0)))


def loads(stance, heading):
    """Loads >= 0 that balance weight and friction's moment about the horizontal, or None."""
    way = np.array([math.cos(heading), math.sin(heading)])
    rows = np.vstack([np.ones(len(stance.points)), stance.points.T])
    wanted = MASS * GRAVITY * np.array([1.0, *(FRICTION * stance.height * way)])
    found = linprog(np.zeros(len(stance.points)), A_eq=rows, b_eq=wanted)
    return np.asarray(found.x) if found.success else None


@pytest.mark.parametrize("seed", range(40))
def test_loads_exist_where_the_hull_says(seed):
    """Whatever they are, their friction decelerates the body by f g and does not turn it."""
    body = stance(seed)
    heading = 0.7 * seed
    found = loads(body, heading)
    assert body.slides(FRICTION, heading) == (found is not None)
    if found is None:
        return
    way = np.array([math.cos(heading), math.sin(heading)])
    forces = -FRICTION * found[:, None] * way
    moment = body.points[:, 0] * forces[:, 1] - body.points[:, 1] * forces[:, 0]
    assert moment.sum() == pytest.approx(0.0, abs=1e-8)
    acceleration = forces.sum(axis=0) @ way / MASS
    assert stopping_distance(0.5, FRICTION, GRAVITY) == pytest.approx(
        0.5**2 / -2 / acceleration
    )
