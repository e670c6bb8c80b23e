"""Holding: how long friction keeps a body at rest while the slider moves."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from plumbob.analytic.systems.slider_path import Piece
from plumbob.analytic.systems.three_points.equations import Mechanics, configuration
from plumbob.analytic.systems.three_points.rest import EDGE, load_factor, needed_wrench, simply_held

SAMPLES = 65


def excess_load(body: Mechanics, piece: Piece, time: float, heading: float) -> float:
    """Load factor of friction at local `time` [s], less 1: the body is held up to 0."""
    at = configuration(body, piece, np.array([time]))
    force, torque = needed_wrench(body, at, heading)
    return load_factor(at.limits[0], at.arms[0], complex(force[0]), float(torque[0]))[0] - 1.0


def held_until(
    body: Mechanics, piece: Piece, start: float, duration: float, heading: float
) -> float | None:
    """First local time [s] after `start` at which a body held then is held no more, or None if it
    is held until `duration`; nothing changes on a piece without end."""
    if not np.isfinite(duration):
        return None
    shares = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, SAMPLES)))
    times = start + (duration - start) * shares
    at = configuration(body, piece, times)
    force, torque = needed_wrench(body, at, heading)
    held = simply_held(at, force, torque)
    for k in np.flatnonzero(~held):
        if k == 0 or excess_load(body, piece, float(times[k]), heading) <= EDGE:
            continue
        low, high = float(times[k - 1]), float(times[k])
        if excess_load(body, piece, low, heading) >= 0.0:
            return low
        return float(
            brentq(
                lambda t: excess_load(body, piece, t, heading),
                low,
                high,
                xtol=1e-300,
                rtol=4e-16 * 4,
            )
        )
    return None
