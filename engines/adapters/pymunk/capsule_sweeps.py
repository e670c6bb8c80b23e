"""How many sweeps over its joints a capsule needs in a step, and what they leave of a velocity."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from plumbob.analytic.reference import Array

LEFT = 1e-5  # of a velocity that friction is to take, after the sweeps of one step
MOST = 5000  # sweeps, which take half a millisecond


def left_by_sweep(masses: Sequence[float], joints: Sequence[Array]) -> float:
    """Largest share of a velocity that one sweep of the solver leaves while every joint asks for
    rest: `masses` (or moments) of the velocities, shape (n,), and for each joint in turn the
    directions in which it works, shape (k, n).

    A sweep solves one joint after the other, so it is the product of their projections, and what it
    leaves is their spectral radius. Momentum goes from the slider to the ground by way of what
    stands there, in one sweep no more of it than that can carry: light feet stop a heavy slider
    late.
    """
    inverse, swept = np.diag(1.0 / np.asarray(masses)), np.eye(len(masses))
    for joint in joints:
        pull = inverse @ joint.T
        swept = swept - pull @ np.linalg.solve(joint @ pull, joint @ swept)
    return float(np.abs(np.linalg.eigvals(swept)).max())


def pin(count: int, arm: Array, other: int) -> Array:
    """Velocity of a body at `arm` from its centre of mass [m], less that of a part that does not
    turn: of `count` velocities the body's are the first three and the part's two from `other`."""
    rows = np.zeros((2, count))
    rows[0, [0, 2, other]] = 1.0, -arm[1], -1.0
    rows[1, [1, 2, other + 1]] = 1.0, arm[0], -1.0
    return rows


def sweeps(slowest: float, least: int) -> int:
    """Sweeps after which LEFT of a velocity is left, when each leaves `slowest` of it: `least` or
    more, and MOST or fewer."""
    if slowest >= LEFT ** (1.0 / MOST):
        return max(least, MOST)
    return max(least, math.ceil(math.log(LEFT) / math.log(max(slowest, LEFT))))
