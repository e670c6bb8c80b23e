"""Replays of the free body as a box in three dimensions."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.free_body.rotation import ATTITUDE, RATES
from plumbob.models.scene import Case
from plumbob.reports.analyses.replay.pendulums import TRAIL
from plumbob.reports.analyses.replay.picture import Picture, camera, channels_of_observables

REACH = 1.3  # length of the line along the angular momentum L; the box's corners are at 1
EDGE = 1.45  # half the width of the picture


def body(case: Case, seconds: float) -> Picture:
    """Returns the picture of a free body over `seconds` [s]."""
    moments = np.array(case.problem.inertia)
    # A flat body is drawn with a thickness of a twentieth of its size.
    squares = np.maximum(moments.sum() - 2.0 * moments, 0.0)
    sides = np.maximum(np.sqrt(squares / squares.sum()), 0.05)
    start = case.reference.observe(np.zeros(1))
    momentum = moments * [start[name][0] for name in RATES]
    scale = REACH / (np.linalg.norm(momentum) or 1.0)
    motion, deviations = channels_of_observables(case.reference.observe, ATTITUDE)
    return Picture(
        kind="body",
        box=(-EDGE, EDGE, -EDGE, EDGE),
        geometry={
            "half": (sides / np.linalg.norm(sides)).tolist(),
            "camera": camera(),
            "rate": 0.0,
            "trail": seconds / TRAIL,
            "momentum": (scale * momentum).tolist(),
        },
        sizes={"rad": 1.0},
        motion=motion,
        deviations=deviations,
        apart=_angle_between,
    )


def _angle_between(deviations: Signals) -> dict[str, Array]:
    """Returns the angle [rad] between a run's attitude and the exact attitude. For small angles, it
    is twice the distance of the quaternions."""
    return {"rad": 2.0 * np.linalg.norm([deviations[name] for name in ATTITUDE], axis=0)}
