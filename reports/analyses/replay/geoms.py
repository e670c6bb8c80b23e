"""The replay of an audit: a model's certified motion, and the motion at the model's step over
it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from itertools import product

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.engines.audit.audit import Audit
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.replay import assemble_replay, run_deviations
from plumbob.reports.analyses.replay.pendulums import TRAIL
from plumbob.reports.analyses.replay.picture import Picture, camera, channels_of_observables
from plumbob.reports.analyses.replay.samples import Samples
from plumbob.reports.view.notation import seconds
from plumbob.reports.view.records import Layer, Replay

ERROR = "error"  # channel of the largest corner displacement [m] from the certified motion
AXES = ("x", "y", "z", "qw", "qx", "qy", "qz")  # components of a body's pose
ELEVATION = math.radians(15.0)  # [rad] elevation of the camera, as in the picture of the model
COUNT, VALUES = 401, 80_000  # most samples; most numbers in a replay
MARGIN = 0.05  # space below the picture for the ruler, relative to the picture's diagonal


def audit_replay(audit: Audit) -> Replay | None:
    """Returns the replay of an audit, up to the time to which its error is known. None if no motion
    is certified, nothing moves, or no moving body has a shape."""
    model = audit.model
    if audit.found is None or audit.still or not any(solid.body for solid in model.solids):
        return None
    exact_states, own_states = audit.states
    exact = _channels(audit, model.poses(exact_states))
    own = _channels(audit, model.poses(own_states))
    displacements = model.corners(own_states) - model.corners(exact_states)
    own[ERROR] = np.linalg.norm(displacements, axis=2).max(axis=1)
    exact[ERROR] = np.zeros(len(displacements))
    times = audit.script.times[: audit.found.index + 1]
    picture = _picture(audit, times, exact)
    count = min(COUNT, max(VALUES // max(len(exact), 1), 51))
    grid = np.linspace(0.0, float(times[-1]), count)
    name = f"{audit.integrator} at {seconds(audit.step)}"
    certified = (Layer("exact", "certified motion", ""), Samples(grid, picture.motion(grid)))
    run = run_deviations(picture, Trajectory(times, own), "first", name, "the model's own")
    return assemble_replay(audit.name, audit.script.duration, picture, certified, [run])


def _channels(audit: Audit, poses: Array) -> dict[str, Array]:
    """Returns the poses of the moving bodies with a solid, as channels named by body and axis;
    `poses` has shape (n, bodies, 7). A quaternion has the sign that continues the one before it."""
    bodies = sorted({solid.body for solid in audit.model.solids} - {0})
    flips = np.sum(poses[1:, :, 3:] * poses[:-1, :, 3:], axis=2) < 0.0
    signs = np.where(np.cumsum(flips, axis=0) % 2, -1.0, 1.0)
    poses[1:, :, 3:] *= signs[..., None]
    pairs = product(bodies, enumerate(AXES))
    return {f"{body}{axis}": poses[:, body, i] for body, (i, axis) in pairs}


def _picture(audit: Audit, times: Array, exact: Signals) -> Picture:
    """Returns the picture of a model, seen from -y and from above, as in the model's own
    picture."""
    assert audit.found is not None
    view = camera(-math.pi / 2.0, ELEVATION)
    solids = audit.model.solids
    names = audit.model.bodies
    bodies = [int(name[:-1]) for name in exact if name.endswith("x") and "q" not in name]
    worst = [body for body in bodies if names[body] == audit.found.own.worst]
    low, high = _extent(audit, exact, bodies, view)
    size = float(np.hypot(*(high - low)))

    def interpolate(at: Array) -> Signals:
        """Returns the exact channels at the times `at` [s], linear between the periods' ends."""
        return {name: np.interp(at, times, values) for name, values in exact.items()}

    motion, deviations = channels_of_observables(interpolate, list(exact))
    return Picture(
        kind="geoms",
        box=(low[0], high[0], low[1] - MARGIN * size, high[1]),
        geometry={
            "camera": view,
            "rate": 0.0,
            "trail": float(times[-1]) / TRAIL,
            "worst": worst[0] if worst else bodies[0],
            "bodies": bodies,
            "solids": [{**asdict(s), "points": np.round(s.points, 5).tolist()} for s in solids],
        },
        sizes={"m": size},
        motion=motion,
        deviations=deviations,
        apart=lambda differences: {"m": differences[ERROR]},
    )


def _extent(
    audit: Audit, exact: Signals, bodies: Sequence[int], view: list[list[float]]
) -> tuple[Array, Array]:
    """Returns the lower left and the upper right corner [m], shape (2,) each, of a picture that
    holds the moving bodies at all times."""
    reach = 0.0  # [m] largest distance of a point of a solid from its body's frame
    for solid in audit.model.solids:
        if solid.body:
            reach = max(reach, np.linalg.norm(solid.points, axis=1).max() + solid.radius)
    positions = []
    for body in bodies:
        in_world = np.array([exact[f"{body}{axis}"] for axis in "xyz"])
        positions.append(view[:2] @ in_world)
    low = np.min(positions, axis=(0, 2)) - reach
    high = np.max(positions, axis=(0, 2)) + reach
    return low, high
