"""The replay of an audit: a model's certified motion, and the motion at the model's step over
it."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.audit import Audit
from plumbob.engines.drawn_mechanism import DrawnMechanism
from plumbob.reports.analyses.replay import assemble_replay, drawn_run
from plumbob.reports.analyses.replay.coordinates import interpolated
from plumbob.reports.analyses.replay.picture import Picture
from plumbob.reports.records.notation import seconds
from plumbob.reports.records.page_records import Layer, Replay

MAX_REPLAY_SAMPLES, MAX_REPLAY_NUMBERS = 401, 80_000  # most samples; most numbers in a replay
FEWEST_REPLAY_SAMPLES = 51


def audit_replay(audit: Audit) -> Replay | None:
    """Returns the replay of an audit, up to the time to which its error is known. None if no motion
    is certified, nothing moves, or no moving body has a shape."""
    model = audit.model
    mechanism = model.drawn
    if audit.found is None or audit.still or not any(s.body for s in mechanism.solids):
        return None
    states = audit.states
    width = model.layout.velocity.start
    exact, own = (_continued(mechanism, values[:, :width]) for values in states)
    displacements = np.subtract(*map(model.corners, states))
    errors = np.linalg.norm(displacements, axis=2).max(axis=1)
    times = audit.script.times[: audit.found.index + 1]
    fitting = max(MAX_REPLAY_NUMBERS // width, FEWEST_REPLAY_SAMPLES)
    grid = np.linspace(0.0, float(times[-1]), min(MAX_REPLAY_SAMPLES, fitting))
    layer = Layer("first", f"{audit.integrator} at {seconds(audit.step)}", "the model's own")
    return assemble_replay(
        audit.name,
        audit.script.duration,
        Picture(mechanism, interpolated(times, exact, grid)),
        grid,
        [drawn_run(layer, times, own - exact, errors)],
        Layer("exact", "certified motion", ""),
    )


def _continued(mechanism: DrawnMechanism, coordinates: Array) -> Array:
    """Returns coordinates, shape (n, k), in which each quaternion has the sign that continues the
    quaternion before it."""
    continued = np.array(coordinates)
    for place in mechanism.quaternions:
        turns = continued[:, place]
        flips = np.sum(turns[1:] * turns[:-1], axis=1) < 0.0
        turns[1:] *= np.where(np.cumsum(flips) % 2, -1.0, 1.0)[:, None]
    return continued
