"""The largest mean speed of repeated manoeuvres, in closed form."""

from __future__ import annotations

from plumbob.analytic.systems.capsule import longest_stroke
from plumbob.analytic.systems.manoeuvres import mean_speed
from plumbob.analytic.systems.manoeuvres.repeated_line import RepeatedLine
from plumbob.models.tripod_capsule.parameters import CHECK, read_capsule
from plumbob.reports.analyses.analysis import Analysis, Record

STROKE, ACCELERATION_RATIO = 0.2, 10.0  # [m]; ratio of w1 to f g/mu
CHECKED_STROKE = 0.0817786125  # [m] stroke of the check manoeuvre


def numbers() -> Record:
    """Returns the mean speed [m/s] of the check manoeuvre and the largest mean speeds under several
    bounds."""
    body = read_capsule(CHECK)
    holding = body.holding_acceleration
    low, high = longest_stroke(body, 0.0)
    pushed = mean_speed.fastest_manoeuvre(body, ACCELERATION_RATIO * holding, STROKE)
    return Record(
        # mean speed of the check manoeuvre
        checked=mean_speed.mean_speed(body, 3 * holding, 0.8 * holding, CHECKED_STROKE, 0.9),
        pushed=RepeatedLine(pushed, 1).mean_speed,  # largest for this stroke, with w1 of `push`
        limit=mean_speed.fastest_speed(body, STROKE),  # largest for this stroke, w1 unbounded
        most=mean_speed.fastest_speed(body, high - low),  # largest for the longest stroke
        longest=high - low,  # [m] longest stroke
        stroke=STROKE,  # [m]
        check_stroke=CHECKED_STROKE,  # [m]
        push=ACCELERATION_RATIO,
    )


MEAN_SPEED = Analysis("capsule_train/mean_speed", exact=numbers)
