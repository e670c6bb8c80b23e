"""Coordinates of a mechanism from the observables of its motion, for replays."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.engines.drawn_mechanism import JOINT_WIDTHS, DrawnMechanism, SceneDrawing, frames
from plumbob.models.scene import Case

MOST_REPEATS = 8  # most corrections of a motion's coordinates; most motions need one or two
DONE = 1e-12  # [m, rad] largest correction after which there is no other
# samples of a motion in which the jumps of a prescribed velocity are no more than a pixel
FINE_SAMPLES = 16_001
ROUNDED = 1e-15  # [m, rad] largest change of a coordinate that is rounding alone
COORDINATE_NUDGE = 1e-6  # [m, rad] change of a coordinate that gives a derivative
# smallest singular value, relative to the largest one, of a change that observables determine
LEAST_EFFECT = 1e-6


def shown_observables(case: Case, coordinates: Array) -> Signals:
    """Returns the observables of a case that coordinates determine, at coordinates of shape (n,
    coordinates)."""
    file = case.system.model_file
    assert file is not None
    # A free or a ball joint has fewer velocities than coordinates; those that are left are zero.
    at_rest = np.zeros_like(coordinates)
    observed = file.observe(case.problem, coordinates, at_rest)
    moved = file.observe(case.problem, coordinates, at_rest + 1.0)
    return {
        name: values for name, values in observed.items() if np.array_equal(values, moved[name])
    }


def with_prescribed_joints(case: Case, drawing: SceneDrawing) -> SceneDrawing:
    """Returns the drawing of a case at FINE_SAMPLES, in which the coordinate of each joint with a
    prescribed velocity is the integral of that velocity."""
    times, step = np.linspace(0.0, case.scene.duration, FINE_SAMPLES, retstep=True)
    coordinates = _drawn_coordinates(case, drawing, times)
    file = case.system.model_file
    velocities = file.ideal(case.problem).velocities if file else {}
    first = 0
    for joint in drawing.mechanism.joints:
        if joint.name in velocities:
            rates = velocities[joint.name](times)
            moved = np.cumsum(step * (rates[:-1] + rates[1:]) / 2.0)
            coordinates[1:, first] = coordinates[0, first] + moved
        first += JOINT_WIDTHS[joint.kind]
    return SceneDrawing(drawing.mechanism, coordinates)


def _drawn_coordinates(case: Case, drawing: SceneDrawing, times: Array) -> Array:
    """Returns the coordinates of the drawing of a case at times [s], shape (n, coordinates)."""
    samples = np.linspace(0.0, case.scene.duration, len(drawing.coordinates))
    return interpolated(samples, drawing.coordinates, times)


def interpolated(times: Array, values: Array, at: Array) -> Array:
    """Returns values at times [s], shape (n, k), interpolated linearly at the times `at`."""
    return np.stack([np.interp(at, times, column) for column in values.T], axis=1)


def exact_coordinates(case: Case, drawing: SceneDrawing, times: Array) -> Array:
    """Returns coordinates of the exact motion of a case at times [s], shape (n, coordinates). They
    have the exact observables. Where no observable shows a coordinate, it is that of the
    drawing."""
    near = _drawn_coordinates(case, drawing, times)
    exact = case.reference.observe(times)
    observed = shown_observables(case, near)
    missing = {name: exact[name] - observed[name] for name in observed if name in exact}
    return near + coordinate_changes(case, drawing.mechanism, near, missing)


def coordinate_changes(
    case: Case, mechanism: DrawnMechanism, coordinates: Array, wanted: Signals
) -> Array:
    """Returns the smallest changes of coordinates, shape (n, coordinates), that change observables
    of a case by `wanted`, shape (n,) each, and keep the loops of the mechanism closed."""
    before = shown_observables(case, coordinates)
    names = [name for name in wanted if name in before]
    changes = np.zeros_like(coordinates)

    def missing(changes: Array) -> Array:
        """Returns what the changes lack of those wanted, of quaternions of length 1, and of closed
        loops, shape (n, k)."""
        near = coordinates + changes
        after = shown_observables(case, near)
        rows = [wanted[name] - (after[name] - before[name]) for name in names]
        rows += [1.0 - np.square(near[:, at]).sum(axis=1) for at in mechanism.quaternions]
        return np.array(rows + _gaps(mechanism, near)).T

    for _ in range(MOST_REPEATS):
        nudges = COORDINATE_NUDGE * np.eye(coordinates.shape[1])
        columns = [missing(changes - nudge) - missing(changes + nudge) for nudge in nudges]
        by_coordinates = np.stack(columns, axis=2) / (2.0 * COORDINATE_NUDGE)
        inverse = np.linalg.pinv(by_coordinates, LEAST_EFFECT)
        correction = np.einsum("nij,nj->ni", inverse, missing(changes))
        changes = changes + correction
        if np.abs(correction).max() <= DONE:
            break
    changes[np.abs(changes) <= ROUNDED] = 0.0
    return changes


def _gaps(mechanism: DrawnMechanism, coordinates: Array) -> list[Array]:
    """Returns the distances along x, y and z that the loops of a mechanism lack, shape (n,) each,
    at coordinates, shape (n, k)."""
    if not mechanism.loops:
        return []
    placed = frames(mechanism, coordinates)
    gaps = list[Array]()
    for (one, other), (here, there) in mechanism.loops:
        gap = placed.placed(other, there[None]) - placed.placed(one, here[None])
        gaps += list(gap[:, 0].T)
    return gaps
