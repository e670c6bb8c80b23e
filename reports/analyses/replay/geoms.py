"""The replay of an audit: a model's certified motion with that of its own steps over it."""

from __future__ import annotations

import math
from dataclasses import asdict

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.audit import Audit
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.replay import assembled, deviating
from plumbob.reports.analyses.replay.picture import (
    Chart,
    Picture,
    around,
    observed,
)
from plumbob.reports.analyses.replay.samples import Channels, Samples
from plumbob.reports.view.notation import metres, seconds
from plumbob.reports.view.records import Layer, Replay

AXES = ("x", "y", "z", "qw", "qx", "qy", "qz")  # of a body's pose
ELEVATION = math.radians(15.0)  # of the camera, as in the picture of the model
COUNT, VALUES = 401, 80_000  # samples, and numbers in all, at most
MOVES = 0.01  # of the reach: a coordinate that moves less has no chart
MARGIN = 0.05  # of the reach below the picture, for the ruler


def audited(audit: Audit) -> Replay | None:
    """The replay of an audit, as far as its error is known; None where nothing is known to move."""
    if audit.model is None or audit.found is None or audit.still:
        return None
    exact, own = (_channels(audit, poses) for poses in map(audit.model.poses, audit.states))
    times = audit.script.times[: audit.found.index + 1]
    picture = _picture(audit, times, exact)
    count = min(COUNT, max(VALUES // max(len(exact), 1), 51))
    grid = np.linspace(0.0, float(times[-1]), count)
    name = f"{audit.integrator} at {seconds(audit.step)}"
    return assembled(
        audit.name,
        audit.script.duration,
        picture,
        (Layer("exact", "certified motion", ""), Samples(grid, picture.motion(grid))),
        [deviating(picture, Trajectory(times, own), "first", name, "the model's own")],
    )


def _channels(audit: Audit, poses: Array) -> Channels:
    """Poses of the bodies that have a solid and move, shape (n, bodies, 7), by body and axis; a
    quaternion has the sign of the one before."""
    assert audit.model is not None
    bodies = sorted({solid.body for solid in audit.model.solids} - {0})
    turned = np.sum(poses[1:, :, 3:] * poses[:-1, :, 3:], axis=2) < 0.0
    poses[1:, :, 3:] *= np.where(np.cumsum(turned, axis=0) % 2, -1.0, 1.0)[..., None]
    return {f"{k}{axis}": poses[:, k, i] for k in bodies for i, axis in enumerate(AXES)}


def _picture(audit: Audit, times: Array, exact: Channels) -> Picture:
    """How the model is drawn, seen as in its picture: from the side of -y, from above."""
    assert audit.model is not None
    assert audit.found is not None
    camera, solids, names = _camera(), audit.model.solids, audit.model.bodies
    bodies = [int(name[:-1]) for name in exact if name.endswith("x") and "q" not in name]
    worst = next((k for k in bodies if names[k] == audit.found.own.worst), bodies[0])
    reach = max(np.linalg.norm(s.points, axis=1).max() + s.radius for s in solids if s.body)
    places = [camera[:2] @ [exact[f"{k}{axis}"] for axis in "xyz"] for k in bodies]
    low, high = np.min(places, axis=(0, 2)) - reach, np.max(places, axis=(0, 2)) + reach
    size = float(np.hypot(*(high - low)))
    end = float(times[-1])

    def apart(deviations: Channels) -> Array:
        lengths = [
            np.linalg.norm([deviations[f"{k}{axis}"] for axis in "xyz"], axis=0) for k in bodies
        ]
        return np.asarray(np.max(lengths, axis=0))

    return Picture(
        "geoms",
        "The certified motion, grey, and the motion of the model's own steps over it, translucent. "
        f"The mark is the centre of mass of {names[worst]}, which is furthest off at the end.",
        (low[0], high[0], low[1] - MARGIN * size, high[1]),
        {
            "camera": camera.tolist(),
            "rate": 0.0,
            "trail": end / 12.0,
            "worst": worst,
            "bodies": bodies,
            "solids": [{**asdict(s), "points": np.round(s.points, 5).tolist()} for s in solids],
        },
        tuple(
            Chart(f"{axis} [m]", "t", (name,), (0.0, end, *around(exact[name])))
            for axis in "xyz"
            if np.ptp(exact[name := f"{worst}{axis}"]) > MOVES * size
        ),
        frozenset(),
        frozenset(exact),
        size,
        *observed(lambda at: {n: np.interp(at, times, v) for n, v in exact.items()}, list(exact)),
        apart,
        lambda deviations: metres(float(apart(deviations).max())),
    )


def _camera() -> Array:
    """Directions in the world to the right, upwards and towards the viewer, shape (3, 3)."""
    rise, tilt = math.cos(ELEVATION), math.sin(ELEVATION)
    return np.array([[1.0, 0.0, 0.0], [0.0, tilt, rise], [0.0, -rise, tilt]])
