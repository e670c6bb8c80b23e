"""Coulomb points at rest: whether static friction suffices, and until when.

The body sticks when a.n <= sum f N_i |G_i a| for every acceleration a = (x, y, angle) of the body,
G_i a being that of support i and n the wrench that moves the body: n then lies in the sum of the
friction discs. How far it is from that, and how motion starts, is decided in `implicit_friction`.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.slider_path import Piece, StraightPiece
from plumbob.analytic.systems.three_points.equations import (
    Complex,
    Configuration,
    Mechanics,
    configuration,
    cross,
    mechanics,
)
from plumbob.analytic.systems.three_points.implicit_friction import load_factor, simply_held

EDGE = 1e-12  # a wrench this near the friction limit, relatively, counts as within it
SAMPLES = 65  # of a rest, for the first time at which friction does not suffice


def needed_wrench(body: Mechanics, at: Configuration) -> tuple[Complex, Array]:
    """Force [N] and torque about G [N m] that friction must balance for the body to stay at rest,
    shape (n,): the slider's reaction -m w."""
    force = -body.mass * body.mass_ratio * at.acceleration
    return np.asarray(force), -body.reduced_mass * cross(at.position, at.acceleration)


def excess_load(body: Mechanics, piece: Piece, time: float) -> float:
    """Load factor of static friction at local `time` [s], less 1: the body sticks up to 0."""
    at = configuration(body, piece, np.array([time]))
    (force,), (torque,) = needed_wrench(body, at)
    return load_factor(at.limits[0].tolist(), at.arms[0].tolist(), force, torque)[0] - 1.0


def holding_limit(capsule: Capsule, place: complex, direction: float) -> float:
    """Largest |w| [m/s^2] of the slider at `place` relative to C [m], along `direction` [rad, from
    the body's x axis], that leaves the body at rest: the load is proportional to |w|. Along lines
    through C it is f g/mu (Chernousko 2020, eq. 21)."""
    trial = capsule.holding_acceleration
    piece = StraightPiece(1.0, (place.real, place.imag), direction, 0.0, 0.0, trial)
    return trial / (1.0 + excess_load(mechanics(capsule), piece, 0.0))


def held_until(body: Mechanics, piece: Piece, start: float) -> float | None:
    """First local time [s] after `start` at which static friction no longer suffices, or None if it
    does to the end of the `piece`; where that has no end nothing changes."""
    from scipy.optimize import brentq

    if not np.isfinite(duration := piece.duration):
        return None
    fractions = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, SAMPLES)))
    times = start + (duration - start) * fractions
    at = configuration(body, piece, times)
    pulls = zip(*needed_wrench(body, at), strict=True)
    excess = partial(excess_load, body, piece)
    for k, (limits, arms, pull) in enumerate(zip(at.limits, at.arms, pulls, strict=True)):
        if k == 0 or simply_held(limits, arms, *pull) or excess(float(times[k])) <= EDGE:
            continue
        low = float(times[k - 1])
        high = float(times[k])
        if excess(low) >= 0.0:
            return low
        return float(brentq(excess, low, high, xtol=1e-300, rtol=1.6e-15))
    return None
