"""Coulomb points at rest: whether static friction suffices, and until when.

A wrench n moves the body at rest. For an acceleration a = (x, y, angle) of the body, support i has
the acceleration G_i a. The body sticks if a.n <= sum f N_i |G_i a| for every a: then n lies in the
sum of the friction discs. `implicit_friction` decides how far n is from that set, and how motion
starts.
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

EDGE = 1e-12  # relative excess over the friction limit at which the body still sticks
SAMPLES = 65  # times in a rest at which the load is examined, to bracket the end of the rest


def needed_wrench(body: Mechanics, at: Configuration) -> tuple[Complex, Array]:
    """Returns the force [N] and the torque about G [N m], shape (n,), that friction must balance
    for the body to stay at rest: the slider's reaction -m w."""
    force = -body.mass * body.mass_ratio * at.acceleration
    return np.asarray(force), -body.reduced_mass * cross(at.position, at.acceleration)


def excess_load(body: Mechanics, piece: Piece, time: float) -> float:
    """Returns the load factor of static friction at local `time` [s], minus 1: the body sticks if
    the result is at most 0."""
    at = configuration(body, piece, np.array([time]))
    (force,), (torque,) = needed_wrench(body, at)
    return load_factor(at.limits[0].tolist(), at.arms[0].tolist(), force, torque)[0] - 1.0


def holding_limit(capsule: Capsule, place: complex, direction: float) -> float:
    """Returns the largest acceleration |w| [m/s^2] of the slider that leaves the body at rest, with
    the slider at `place` relative to C [m] and w along `direction` [rad, from the body's x axis].
    On lines through C it is f g/mu (Chernousko 2020, eq. 21). The load is proportional to |w|."""
    trial = capsule.holding_acceleration
    piece = StraightPiece(1.0, (place.real, place.imag), direction, 0.0, 0.0, trial)
    return trial / (1.0 + excess_load(mechanics(capsule), piece, 0.0))


def held_until(body: Mechanics, piece: Piece, start: float) -> float | None:
    """Returns the first local time [s] after `start` at which static friction no longer suffices.
    Returns None if it suffices to the end of the `piece`, or if the piece has no end: then the load
    is constant."""
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
