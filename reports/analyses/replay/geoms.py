"""The replay of an audit: a model's certified motion, and the motion at the model's step over
it."""

from __future__ import annotations

import math
from dataclasses import asdict

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.engines.audit.audit import Audit
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.replay import assembled, deviating
from plumbob.reports.analyses.replay.pendulums import TRAIL
from plumbob.reports.analyses.replay.picture import Picture, camera, observed
from plumbob.reports.analyses.replay.samples import Samples
from plumbob.reports.view.notation import seconds
from plumbob.reports.view.records import Layer, Replay

ERROR = "error"  # channel of the largest corner displacement [m] from the certified motion
AXES = ("x", "y", "z", "qw", "qx", "qy", "qz")  # components of a body's pose
ELEVATION = math.radians(15.0)  # [rad] elevation of the camera, as in the picture of the model
COUNT, VALUES = 401, 80_000  # most samples; most numbers in a replay
MARGIN = 0.05  # space below the picture for the ruler, relative to the picture's diagonal


def audited(audit: Audit) -> Replay | None:
    """Returns the replay of an audit, up to the time to which its error is known. None if no motion
    is certified, nothing moves, or no moving body has a shape."""
    model = audit.model
    if audit.found is None or audit.still or not any(solid.body for solid in model.solids):
        return None
    states = audit.states
    exact, own = (_channels(audit, poses) for poses in map(model.poses, states))
    here, there = map(model.corners, states)
    own[ERROR] = np.linalg.norm(there - here, axis=2).max(axis=1)
    exact[ERROR] = np.zeros(len(here))
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


def _channels(audit: Audit, poses: Array) -> dict[str, Array]:
    """Returns the poses of the moving bodies with a solid, as channels named by body and axis;
    `poses` has shape (n, bodies, 7). A quaternion has the sign that continues the one before it."""
    bodies = sorted({solid.body for solid in audit.model.solids} - {0})
    turned = np.sum(poses[1:, :, 3:] * poses[:-1, :, 3:], axis=2) < 0.0
    poses[1:, :, 3:] *= np.where(np.cumsum(turned, axis=0) % 2, -1.0, 1.0)[..., None]
    return {f"{k}{axis}": poses[:, k, i] for k in bodies for i, axis in enumerate(AXES)}


def _picture(audit: Audit, times: Array, exact: Signals) -> Picture:
    """Returns the picture of a model, seen from -y and from above, as in the model's own
    picture."""
    assert audit.found is not None
    view = camera(-math.pi / 2.0, ELEVATION)
    solids = audit.model.solids
    names = audit.model.bodies
    bodies = [int(name[:-1]) for name in exact if name.endswith("x") and "q" not in name]
    worst = next((k for k in bodies if names[k] == audit.found.own.worst), bodies[0])
    reach = max(np.linalg.norm(s.points, axis=1).max() + s.radius for s in solids if s.body)
    places = [view[:2] @ np.array([exact[f"{k}{axis}"] for axis in "xyz"]) for k in bodies]
    low = np.min(places, axis=(0, 2)) - reach
    high = np.max(places, axis=(0, 2)) + reach
    size = float(np.hypot(*(high - low)))

    return Picture(
        "geoms",
        (low[0], high[0], low[1] - MARGIN * size, high[1]),
        {
            "camera": view,
            "rate": 0.0,
            "trail": float(times[-1]) / TRAIL,
            "worst": worst,
            "bodies": bodies,
            "solids": [{**asdict(s), "points": np.round(s.points, 5).tolist()} for s in solids],
        },
        {"m": size},
        *observed(
            lambda at: {n: np.interp(at, times, v) for n, v in exact.items()}, list(exact)
        ),
        lambda deviations: {"m": deviations[ERROR]},
    )
