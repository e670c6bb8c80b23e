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
    ComplexForces,
    Configuration,
    Mechanics,
    configuration,
    cross,
    mechanics,
)
from plumbob.analytic.systems.three_points.implicit_friction import load_factor, surely_sticks

# Relative excess of a load over the friction limit at which the body still sticks
LIMIT_ROUNDING = 1e-12
# times in a rest at which the load is examined, to bracket the end of the rest
LOAD_SAMPLES = 65


def needed_wrench(body: Mechanics, terms: Configuration) -> tuple[ComplexForces, Array]:
    """Returns the force [N] and the torque about G [N m], shape (n,), that friction must balance
    for the body to stay at rest: the slider's reaction -m w."""
    force = -body.mass * body.mass_ratio * terms.acceleration
    return np.asarray(force), -body.reduced_mass * cross(terms.position, terms.acceleration)


def excess_load(body: Mechanics, piece: Piece, time: float) -> float:
    """Returns the load factor of static friction at local `time` [s], minus 1: the body sticks if
    the result is at most 0."""
    terms = configuration(body, piece, np.array([time]))
    (force,), (torque,) = needed_wrench(body, terms)
    return load_factor(terms.limits[0].tolist(), terms.arms[0].tolist(), force, torque)[0] - 1.0


def holding_limit(capsule: Capsule, place: complex, direction: float) -> float:
    """Returns the largest acceleration |w| [m/s^2] of the slider that leaves the body at rest, with
    the slider at `place` relative to C [m] and w along `direction` [rad, from the body's x axis].
    On lines through C it is f g/mu (Chernousko 2020, eq. 21). The load is proportional to |w|."""
    trial = capsule.holding_acceleration
    piece = StraightPiece(
        duration=1.0,
        origin=(place.real, place.imag),
        direction=direction,
        position=0.0,
        speed=0.0,
        acceleration=trial,
    )
    return trial / (1.0 + excess_load(mechanics(capsule), piece, 0.0))


def held_until(body: Mechanics, piece: Piece, start: float) -> float | None:
    """Returns the first local time [s] after `start` at which static friction no longer suffices.
    Returns None if it suffices to the end of the `piece`, or if the piece has no end: then the load
    is constant."""
    from scipy.optimize import brentq

    duration = piece.duration
    if not np.isfinite(duration):
        return None
    fractions = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, LOAD_SAMPLES)))
    times = start + (duration - start) * fractions
    terms = configuration(body, piece, times)
    wrenches = zip(*needed_wrench(body, terms), strict=True)
    excess = partial(excess_load, body, piece)
    samples = zip(times.tolist(), terms.limits, terms.arms, wrenches, strict=True)
    last_held, *_ = next(samples)
    for time, limits, arms, wrench in samples:
        if surely_sticks(limits, arms, *wrench) or excess(time) <= LIMIT_ROUNDING:
            last_held = time
            continue
        if excess(last_held) >= 0.0:
            return float(last_held)
        return float(brentq(excess, last_held, time, xtol=1e-300, rtol=1.6e-15))
    return None
