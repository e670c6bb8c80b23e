"""Further statements of the source on turns, each computed on the exact motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.analytic.systems.three_points.balance import balance, exchange
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.engines.study.results import Study
from plumbob.models.tripod_capsule.turn import EPSILONS
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_turn.course import exact_course
from plumbob.reports.analyses.capsule_turn.turns import facts, name_of, turn
from plumbob.reports.analyses.measurements import problem

SHOWN = 0.3  # epsilon: friction is seen there
SMALL, SHORTER = 0.03, 10.0  # epsilon of a turn, and how many times shorter it is made
THOUSAND = "capsule-turn/thousand"
NODES = 32  # Gauss points of a smooth segment


def friction_turning(manoeuvre: TurnManoeuvre, motion: ThreePointMotion) -> tuple[float, float]:
    """Largest |R| of eq. 24 over R_0 while the slider moves, and the integral of R over that time
    [rad/s]: by eq. 24 the body's rate at 2 tau, since that of the slider is zero again."""
    x, weights = np.polynomial.legendre.leggauss(NODES)
    largest, total, stop = 0.0, 0.0, 2.0 * manoeuvre.half_time * (1.0 - 1e-12)
    for begin, segment in zip(motion.begins, motion.segments, strict=True):
        if begin >= stop or not np.isfinite(segment.end):
            continue
        load, pace = exchange(motion, segment, 0.5 * (x + 1.0))
        rate: Array = load.torque / load.at.inertia
        largest = max(largest, float(np.abs(rate).max()))
        total += float(np.sum(0.5 * weights * pace * rate))
    return largest / manoeuvre.friction_bound, total


def shortened() -> tuple[float, float]:
    """Body angle [rad] at 2 tau of the turn of SMALL, and with the same Z in a SHORTERth of the
    time."""
    manoeuvre = turn(SMALL)
    less = replace(manoeuvre, half_time=manoeuvre.half_time / SHORTER)
    end = three_point_motion(less.capsule, less.path).at(np.array([2.0 * less.half_time]))
    return facts(SMALL)["body_angle"], float(end.heading[0])


def numbers(study: Study) -> Record:
    """The exact motion's numbers for each statement."""
    manoeuvre, motion = turn(SHOWN), problem(name_of(SHOWN)).motion.single
    sums, about = balance(motion), facts(SHOWN)
    phases = np.array([2.0, about["rest_time"] / manoeuvre.half_time])
    moved, later = exact_course(SHOWN, phases)[1]
    many = problem(THOUSAND).motion
    each = float(many.single.at(np.array([many.single.rest_time])).heading[0])
    friction, integral = friction_turning(manoeuvre, motion)
    rate = about["angular_velocity_at_stop"]
    usual, shorter = shortened()
    return Record(
        # the largest of energy and momenta, relative
        imbalance=max(sums.energy, sums.momentum, sums.angular_momentum),
        friction=friction,  # largest |R| over R_0
        integral=integral,  # of R until 2 tau [rad/s]
        rate=rate,  # of the body at 2 tau [rad/s]
        # body angle at 2 tau [rad], of the largest epsilon and the smallest
        ends=(facts(EPSILONS[0])["body_angle"], facts(EPSILONS[-1])["body_angle"]),
        usual=usual,  # body angle of the turn of SMALL [rad]
        shorter=shorter,  # and in a SHORTERth of the time
        count=many.count,  # of repeated turns
        total=many.count * each,  # body angle of all of them [rad]
        moved=float(np.hypot(*moved)),  # C until 2 tau [m]
        moved_after=float(np.hypot(*(later - moved))),
        decay=about["rest_time"] - about["stop_time"],  # time from 2 tau to rest [s]
        shown=SHOWN,
        epsilons=(EPSILONS[0], EPSILONS[-1]),
        thousand=THOUSAND,
        gap=abs(integral / rate - 1.0),  # relative difference of the integral and the rate
    )


SOURCE = Analysis("capsule_turn/source", numbers)
