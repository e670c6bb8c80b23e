"""Replays of the free body: a box with its angular velocity, in three dimensions."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.free_body.rotation import ATTITUDE, RATES
from plumbob.models.scene import Case
from plumbob.reports.analyses.replay.cone import camera
from plumbob.reports.analyses.replay.picture import (
    Chart,
    Picture,
    around,
    observed,
    radians,
)
from plumbob.reports.analyses.replay.samples import Channels

CORNER = 1.0  # distance of the box's corners from its centre: the picture has no scale
REACH = 1.3  # of the arrow of the largest angular velocity, and of the line along L
EDGE = 1.45  # what the picture shows, to each side
STILL = 1e-9  # of a channel's size: a range below it is rounding


def body(case: Case, seconds: float) -> Picture:
    """The replay of a free body over `seconds` [s]."""
    moments = np.array(case.problem.inertia)
    half, exact = _half(moments), case.reference.observe(np.linspace(0.0, seconds, 801))
    speeds = np.sqrt(np.sum([exact[name] ** 2 for name in RATES], axis=0))
    momentum = moments * [exact[name][0] for name in RATES]
    size = float(np.linalg.norm(momentum)) or 1.0
    moving = frozenset(
        name
        for name in (*ATTITUDE, *RATES)
        if np.ptp(exact[name]) > STILL * float(speeds.max() if name in RATES else 1.0)
    )
    least = 0.05 * float(speeds.max())

    return Picture(
        "body",
        "A box with the body's moments of inertia, turning about its centre; P is one of its "
        "corners. ω is its angular velocity, and L the line of its angular momentum, which keeps "
        "its direction. Beside it ω along the body's own axes x, y and z.",
        (-EDGE, EDGE, -EDGE, EDGE),
        {
            "half": half.tolist(),
            "camera": camera().tolist(),
            "rate": 0.0,
            "trail": seconds / 12.0,
            "momentum": (REACH / size * momentum).tolist(),
            "arrow": REACH / (float(speeds.max()) or 1.0),
        },
        tuple(
            Chart(
                f"ω{axis} [rad/s]", "t", (name,), (0.0, seconds, *around(exact[name], least=least))
            )
            for axis, name in zip(("ₓ", "ᵧ", "_z"), RATES, strict=True)
        ),
        moving & frozenset(ATTITUDE),
        moving,
        1.0,
        *observed(case.reference.observe, (*ATTITUDE, *RATES)),
        apart,
        lambda apart_by: radians(float(apart(apart_by).max())),
    )


def apart(deviations: Channels) -> Array:
    """The angle [rad] between the attitude of a run and the exact one, shape (n,): twice the
    distance of the quaternions, while it is small."""
    squares = np.sum([deviations[name] ** 2 for name in ATTITUDE], axis=0)
    return np.asarray(2.0 * np.sqrt(squares))


def _half(moments: Array) -> Array:
    """Half the sides of a box with these moments, shape (3,), times whatever has its corners at
    CORNER; a flat body keeps a twentieth of that as its thickness."""
    squares = np.maximum(moments.sum() - 2.0 * moments, 0.0)
    sides = np.maximum(np.sqrt(squares / squares.sum()), 0.05)
    return np.asarray(CORNER * sides / np.linalg.norm(sides))
