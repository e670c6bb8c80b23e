"""Replays of the free body: a box, in three dimensions."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.free_body.rotation import ATTITUDE, RATES
from plumbob.models.scene import Case
from plumbob.reports.analyses.replay.pendulums import TRAIL
from plumbob.reports.analyses.replay.picture import Picture, camera, observed

REACH = 1.3  # of the line along L: the box's corners are at 1
EDGE = 1.45  # what the picture shows, to each side


def body(case: Case, seconds: float) -> Picture:
    """The replay of a free body over `seconds` [s]."""
    moments = np.array(case.problem.inertia)
    # a flat body keeps a twentieth of its size as its thickness
    squares = np.maximum(moments.sum() - 2.0 * moments, 0.0)
    sides = np.maximum(np.sqrt(squares / squares.sum()), 0.05)
    start = case.reference.observe(np.zeros(1))
    momentum = moments * [start[name][0] for name in RATES]
    return Picture(
        "body",
        (-EDGE, EDGE) * 2,
        {
            "half": (sides / np.linalg.norm(sides)).tolist(),
            "camera": camera(),
            "rate": 0.0,
            "trail": seconds / TRAIL,
            "momentum": (REACH / (np.linalg.norm(momentum) or 1.0) * momentum).tolist(),
        },
        {"rad": 1.0},
        *observed(case.reference.observe, ATTITUDE),
        _apart,
    )


def _apart(deviations: Signals) -> dict[str, Array]:
    """The angle [rad] between the attitude of a run and the exact one: twice the distance of the
    quaternions, while it is small."""
    return {"rad": 2.0 * np.linalg.norm([deviations[name] for name in ATTITUDE], axis=0)}
