"""The exact motion of a turn: the next term of the formula, and a support that stops
momentarily."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.tripod_capsule.turn import TURN_EPSILONS
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_turn.turns import check_turn, facts

# [rad] body angle at 2 tau by epsilon
CHECKED_BODY_ANGLES = MappingProxyType(
    {0.3: -0.9068671274, 0.1: -0.9888885424, 0.03: -0.9989925407, 0.01: -0.9998879884}
)
# indices of TURN_EPSILONS whose fourth-order errors are far above rounding
SLOPES = slice(1, 5)
# a body with the mass near C, whose supports move more easily in one direction than in the other
SLENDER = MappingProxyType(
    {"inertia": 0.002, "radius": 0.12, "angular_acceleration": 130.0, "half_time": 0.08}
)
TIMES_BESIDE_STOP = (1e-6, 1e-5, 1e-4, 1e-3)  # [s] times before and after the stop of a support


def formula_errors() -> tuple[Record, Record]:
    """Returns the errors of eq. 32, and the errors of eq. 32 with its next term."""
    corrected = _errors("body_angle_corrected", "body_angle_corrected_at_rest")
    return _errors("body_angle_formula", "body_angle_formula"), corrected


def _errors(at_stop: str, at_rest: str) -> Record:
    """Returns the exact body angle minus the angle of a formula [rad] at 2 tau and at rest, for
    each of TURN_EPSILONS, and the slopes of log error against log epsilon, from 0.1 to 0.003.
    `at_stop` and `at_rest` are the names of the formula's angles in `facts`."""
    turns = [facts(epsilon) for epsilon in TURN_EPSILONS]
    errors = {
        "stop": [known["body_angle"] - known[at_stop] for known in turns],
        "rest": [known["body_angle_at_rest"] - known[at_rest] for known in turns],
    }
    log_epsilons = np.log(TURN_EPSILONS[SLOPES])
    slopes = {}
    for name, values in errors.items():
        log_errors = np.log(np.abs(values[SLOPES]))
        slopes[name] = np.polyfit(log_epsilons, log_errors, 1)[0]
    return Record(**errors, slopes=slopes)


def second_order() -> Record:
    """Returns the check values of the body angle, the errors of the formulas, and the coefficients
    of epsilon^2 from theory and from the exact motion."""
    manoeuvre = check_turn(0.1)
    scale = manoeuvre.characteristic_time**2
    correction = manoeuvre.correction
    angles = [(e, known, facts(e)["body_angle"]) for e, known in CHECKED_BODY_ANGLES.items()]
    checks = tuple((e, known, angle, angle - known) for e, known, angle in angles)
    formula, corrected = formula_errors()
    smallest_squared = TURN_EPSILONS[-1] ** 2
    measured = {
        "stop": formula.stop[-1] / smallest_squared,
        "rest": formula.rest[-1] / smallest_squared,
    }
    return Record(
        stop=scale * float(correction.at_stop[2]),  # [rad] coefficient of epsilon^2 at 2 tau
        rest=scale * float(correction.at_rest[2]),  # [rad] coefficient of epsilon^2 at rest
        formula=formula,
        corrected=corrected,
        checks=checks,  # epsilon; body angle at 2 tau [rad]: check value, computed, difference
        epsilons=TURN_EPSILONS,
        # [rad] both coefficients from the exact motion at the smallest epsilon
        measured=measured,
        factor=_logarithm_factor(corrected.rest),
    )


def _logarithm_factor(errors: Sequence[float]) -> float:
    """Returns K of the error K epsilon^4 ln(1/epsilon) + B epsilon^4 at rest, from the errors at
    the two smallest TURN_EPSILONS."""
    larger, smaller = (errors[k] / TURN_EPSILONS[k] ** 4 for k in (-2, -1))
    return (smaller - larger) / math.log(TURN_EPSILONS[-2] / TURN_EPSILONS[-1])


def slender_turn() -> ThreePointMotion:
    """Returns the turn of a body with little inertia, during which a support stops and moves on at
    once."""
    scene = find_scene("capsule-turn", SLENDER)
    single = case_of(scene).problem.motion.single
    assert isinstance(single, ThreePointMotion)
    return single


def slip_speeds(motion: ThreePointMotion, times: Array) -> Array:
    """Returns the slip speed |v_i| [m/s] of each support, shape (3, n), at `times` [s], shape
    (n,)."""
    pose = motion.at(times)
    velocity = (pose.velocity @ [1.0, 1j]) * np.exp(-1j * pose.heading)
    supports = np.asarray(motion.capsule.supports) @ [1.0, 1j]
    return np.asarray(np.abs(velocity + 1j * pose.angular_velocity * supports[:, None]))


def momentary_stop() -> Record:
    """Returns the slip speeds of a support shortly before and after it stops momentarily."""
    single = slender_turn()
    tau = SLENDER["half_time"]
    sides = np.array(TIMES_BESIDE_STOP)
    # A momentary stop is an event of a support between two sliding modes.
    stops = [
        event
        for previous, event in pairwise(single.events)
        if previous.mode == event.mode == "slide" and event.support >= 0
    ]
    touch = stops[0]
    times = np.array([touch.time, *(touch.time - sides), *(touch.time + sides)])
    speed_at_stop, *speeds = slip_speeds(single, times)[touch.support]
    before, after = np.reshape(speeds, (2, -1))
    rows = np.column_stack([sides, before, after, before / sides, after / sides])
    return Record(
        time=touch.time / tau,  # ratio of the stop's time to tau
        support=touch.support + 1,
        speed=speed_at_stop,  # [m/s] slip speed at the stop
        # A row for each of TIMES_BESIDE_STOP: that time [s], the slip speeds before and after
        # [m/s], and both speeds divided by the time [m/s²]
        sides=rows,
        parameters=SLENDER,
    )


SECOND_ORDER = Analysis("capsule_turn/second_order", exact=second_order)
TOUCH = Analysis("capsule_turn/touch", exact=momentary_stop)
