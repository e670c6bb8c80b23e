"""The exact motion of a turn: the formula's next term, and a support that stops for a moment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.tripod_capsule.turn import EPSILONS
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_turn.turns import facts, turn

CHECKED = MappingProxyType(
    {0.3: -0.9068671274, 0.1: -0.9888885424, 0.03: -0.9989925407, 0.01: -0.9998879884}
)  # the body angle at 2 tau [rad] by epsilon
SLOPES = slice(1, 5)  # of EPSILONS: where a fourth order is far above rounding
SLENDER = MappingProxyType(
    {"inertia": 0.002, "radius": 0.12, "angular_acceleration": 130.0, "half_time": 0.08}
)  # the check body's masses nearer to C: a support is easier to move one way than the other
SIDES = (1e-6, 1e-5, 1e-4, 1e-3)  # [s] before and after


def formulas() -> tuple[Record, Record]:
    """Errors of eq. 32, and of it with its next term."""
    corrected = _errors("body_angle_corrected", "body_angle_corrected_at_rest")
    return _errors("body_angle_formula", "body_angle_formula"), corrected


def _errors(at_stop: str, at_rest: str) -> Record:
    """Exact body angle less that of a formula [rad] at 2 tau and at rest, for each of EPSILONS, and
    slopes of log error against log epsilon, from 0.1 to 0.003."""
    turns = [facts(epsilon) for epsilon in EPSILONS]
    errors = {
        "stop": [known["body_angle"] - known[at_stop] for known in turns],
        "rest": [known["body_angle_at_rest"] - known[at_rest] for known in turns],
    }
    logs = np.log(EPSILONS[SLOPES])
    slopes = {n: np.polyfit(logs, np.log(np.abs(e[SLOPES])), 1)[0] for n, e in errors.items()}
    return Record(**errors, slopes=slopes)


def second_order(study: Study) -> Record:
    """The check values, the formulas' errors, and the coefficients."""
    turned = turn(0.1)
    scale = turned.characteristic_time**2
    stop = float(turned.correction.at_stop[2])
    end = float(turned.correction.at_rest[2])
    angles = [(e, known, facts(e)["body_angle"]) for e, known in CHECKED.items()]
    checks = tuple((e, known, angle, angle - known) for e, known, angle in angles)
    formula, corrected = formulas()
    last = EPSILONS[-1] ** 2
    return Record(
        stop=scale * stop,  # coefficient of epsilon^2 [rad] at 2 tau, from theory
        rest=scale * end,
        formula=formula,
        corrected=corrected,
        checks=checks,  # epsilon, the body angle at 2 tau [rad], computed, their difference
        epsilons=EPSILONS,
        # the same coefficients at the smallest epsilon, from the exact motion
        measured={"stop": formula.stop[-1] / last, "rest": formula.rest[-1] / last},
        factor=_factor(corrected.rest),
    )


def _factor(errors: Sequence[float]) -> float:
    """K of an error K epsilon^4 ln(1/epsilon) + B epsilon^4 at rest, from the two smallest."""
    larger, smaller = (errors[k] / EPSILONS[k] ** 4 for k in (-2, -1))
    return (smaller - larger) / math.log(EPSILONS[-2] / EPSILONS[-1])


def motion() -> ThreePointMotion:
    """A turn of a body with little inertia, in which a support stops and leaves at once."""
    scene = find_scene("capsule-turn", SLENDER)
    single = case_of(scene).problem.motion.single
    assert isinstance(single, ThreePointMotion)
    return single


def slip_speeds(motion: ThreePointMotion, times: Array) -> Array:
    """|v_i| [m/s] of each support, shape (3, n), at `times` [s], shape (n,)."""
    pose = motion.at(times)
    velocity = (pose.velocity @ [1.0, 1j]) * np.exp(-1j * pose.heading)
    supports = np.asarray(motion.capsule.supports) @ [1.0, 1j]
    return np.asarray(np.abs(velocity + 1j * pose.angular_velocity * supports[:, None]))


def touching(study: Study) -> Record:
    """The slip speed on either side of the stop."""
    single = motion()
    tau = SLENDER["half_time"]
    sides = np.array(SIDES)
    pairs = pairwise(single.events)
    touch = next(to for of, to in pairs if of.mode == to.mode == "slide" and to.support >= 0)
    times = np.array([touch.time, *(touch.time - sides), *(touch.time + sides)])
    at, *speeds = slip_speeds(single, times)[touch.support]
    before, after = np.reshape(speeds, (2, -1))
    rows = np.column_stack([sides, before, after, before / sides, after / sides])
    return Record(
        time=touch.time / tau,  # over tau
        support=touch.support + 1,
        speed=at,  # there [m/s]
        sides=rows,  # time [s], slip speeds so long before and after, and those over the time
        parameters=SLENDER,
    )


SECOND_ORDER = Analysis("capsule_turn/second_order", second_order)
TOUCH = Analysis("capsule_turn/touch", touching)
