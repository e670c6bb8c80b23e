"""The period of a pendulum as a recorded run shows it, to be held against the closed form."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from plumbob.engines.trajectory import Trajectory

TURN = 2 * np.pi
PERIODS = 3.1  # of a run whose period is measured: two whole ones between crossings, and some more


def swing_period(run: Trajectory | None, centre: float) -> float | None:
    """Mean period [s] of a libration about an angle `centre` [rad]: between upward crossings of it,
    by the cubic through angles and rates at the samples. None where there are not two."""
    if run is None:
        return None
    course = CubicHermiteSpline(run.times, run.observables["theta"], run.observables["theta_dot"])
    places = course.solve(centre, extrapolate=False)
    # a start exactly at the centre may be found just outside the first interval, or not at all
    upward = [t for t in places if np.isfinite(t) and course(t, 1) > 0.0]
    distinct = [t for i, t in enumerate(upward) if i == 0 or t - upward[i - 1] > 1e-9]
    if len(distinct) < 2:
        return None
    return float((distinct[-1] - distinct[0]) / (len(distinct) - 1))


def turn_period(run: Trajectory | None) -> float | None:
    """Mean period [s] of a rotation: over its whole turns. None where there is none."""
    if run is None:
        return None
    theta = run.observables["theta"]
    sense = 1.0 if theta[-1] >= theta[0] else -1.0
    turns = int(abs(theta[-1] - theta[0]) // TURN)
    if turns < 1:
        return None
    course = CubicHermiteSpline(run.times, theta, run.observables["theta_dot"])
    ends = course.solve(float(theta[0] + sense * turns * TURN), extrapolate=False)
    return float(ends[0] - run.times[0]) / turns if len(ends) else None
