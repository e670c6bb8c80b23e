"""Further statements of the source on turns, each computed on the exact motion."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.analytic.systems.three_points.balance import balance, exchange
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.engines.study.results import Study
from plumbob.models.tripod_capsule.turn import EPSILONS
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.capsule_turn.course import exact_course
from plumbob.reports.analyses.capsule_turn.turns import facts, name_of, turn
from plumbob.reports.analyses.measurements import problem

SHOWN = 0.3  # epsilon: friction is seen there
SMALL, SHORTER = 0.03, 10.0  # epsilon of a turn, and how many times shorter it is made
THOUSAND = "capsule-turn/thousand"
NODES = 32  # Gauss points of a smooth segment


@dataclass(frozen=True)
class Statements:
    """Numbers for the source's statements, those without an epsilon of the turn of SHOWN."""

    imbalance: float  # the largest of energy and momenta, relative
    friction: float  # largest |R| over R_0
    integral: float  # of R until 2 tau [rad/s]
    rate: float  # of the body at 2 tau [rad/s]
    ends: tuple[float, float]  # body angle at 2 tau [rad], of the largest epsilon and the smallest
    usual: float  # body angle of the turn of SMALL [rad]
    shorter: float  # and in a SHORTERth of the time
    count: int  # of repeated turns
    total: float  # body angle of all of them [rad]
    moved: float  # C until 2 tau [m]
    moved_after: float
    decay: float  # time from 2 tau to rest [s]
    shown: float = SHOWN
    epsilons: tuple[float, float] = (EPSILONS[0], EPSILONS[-1])
    thousand: str = THOUSAND

    @property
    def gap(self) -> float:
        """Relative difference of the integral and the rate."""
        return abs(self.integral / self.rate - 1.0)


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


def numbers(study: Study) -> Statements:
    """The exact motion's numbers for each statement."""
    manoeuvre, motion = turn(SHOWN), problem(name_of(SHOWN)).motion.single
    sums, about = balance(motion), facts(SHOWN)
    phases = np.array([2.0, about["rest_time"] / manoeuvre.half_time])
    moved, later = exact_course(SHOWN, phases)[1]
    many = problem(THOUSAND).motion
    each = float(many.single.at(np.array([many.single.rest_time])).heading[0])
    return Statements(
        max(sums.energy, sums.momentum, sums.angular_momentum),
        *friction_turning(manoeuvre, motion),
        about["angular_velocity_at_stop"],
        (facts(EPSILONS[0])["body_angle"], facts(EPSILONS[-1])["body_angle"]),
        *shortened(),
        many.count,
        many.count * each,
        float(np.hypot(*moved)),
        float(np.hypot(*(later - moved))),
        about["rest_time"] - about["stop_time"],
    )


SOURCE = Analysis("capsule_turn/source", numbers)
