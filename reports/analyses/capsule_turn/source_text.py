"""Further statements of the source on turns, each computed on the exact motion."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.analytic.systems.three_points.forces import loading
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.analytic.systems.three_points.rest import holding_limit
from plumbob.engines.study.results import Study
from plumbob.models.tripod_capsule.turn import EPSILONS
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_turn.course import exact_course
from plumbob.reports.analyses.capsule_turn.turns import facts, name_of, turn
from plumbob.reports.analyses.measurements import problem

SHOWN = 0.3  # epsilon: friction is seen there
SMALL, SHORTER = 0.03, 10.0  # epsilon of a turn, and how many times shorter it is made
THOUSAND = "capsule-turn/thousand"
PLACES = 24  # round the circle
NODES = 32  # Gauss points of a smooth segment


def friction_turning(
    manoeuvre: TurnManoeuvre, motion: ThreePointMotion
) -> tuple[float, float, complex]:
    """Largest |R| of eq. 24 over R_0 while the slider moves, the integral of R over that time
    [rad/s]: by eq. 24 the body's rate at 2 tau, since that of the slider is zero again; and what
    friction makes of the velocity of the combined centre [m/s]."""
    x, weights = np.polynomial.legendre.leggauss(NODES)
    largest = 0.0
    turned = 0.0
    pushed = 0j
    stop = 2.0 * manoeuvre.half_time * (1.0 - 1e-12)
    for begin, segment in zip(motion.begins, motion.segments, strict=True):
        if begin < stop:
            load = loading(motion, segment, 0.5 * (x + 1.0))
            (force, torque) = load.friction
            spans = 0.5 * weights * load.pace
            rate = torque / load.terms.inertia
            largest = max(largest, float(np.abs(rate).max()))
            turned += float(spans @ rate)
            pushed += (
                complex(spans @ (force * np.exp(1j * load.states[:, 4]))) / motion.body.mass
            )
    return largest / manoeuvre.friction_bound, turned, pushed


def centre_velocity(manoeuvre: TurnManoeuvre, motion: ThreePointMotion) -> complex:
    """Of the combined centre as the slider stops [m/s]."""
    end = motion.at(np.array([2.0 * manoeuvre.half_time]))
    arm = motion.body.mass_ratio * complex(*motion.path.end) * np.exp(1j * end.heading[0])
    return complex(complex(*end.velocity[0]) + 1j * end.angular_velocity[0] * arm)


def shortened() -> tuple[float, float]:
    """Body angle [rad] at 2 tau of the turn of SMALL, and with the same Z in a SHORTERth of the
    time."""
    manoeuvre = turn(SMALL)
    less = replace(manoeuvre, half_time=manoeuvre.half_time / SHORTER)
    end = three_point_motion(less.capsule, less.path).at(np.array([2.0 * less.half_time]))
    return facts(SMALL)["body_angle"], float(end.heading[0])


def numbers(study: Study) -> Record:
    """The exact motion's numbers for each statement, those without an epsilon of the turn of
    SHOWN."""
    manoeuvre = turn(SHOWN)
    motion = problem(name_of(SHOWN)).motion.single
    about = facts(SHOWN)
    velocity = centre_velocity(manoeuvre, motion)
    at_end = about["rest_time"] / manoeuvre.half_time
    moved, later = exact_course(SHOWN, np.array([2.0, at_end]))[1]
    many = problem(THOUSAND).motion
    friction, integral, pushed = friction_turning(manoeuvre, motion)
    usual, shorter = shortened()
    rate = about["angular_velocity_at_stop"]
    return Record(
        # the largest of momentum and angular momentum until 2 tau, relative
        imbalance=max(abs(pushed / velocity - 1.0), abs(integral / rate - 1.0)),
        friction=friction,  # largest |R| over R_0
        integral=integral,  # of R until 2 tau [rad/s]
        rate=rate,  # of the body at 2 tau [rad/s]
        gap=abs(integral / rate - 1.0),
        # body angle at 2 tau [rad], of the largest epsilon and the smallest
        ends=[facts(epsilon)["body_angle"] for epsilon in (EPSILONS[0], EPSILONS[-1])],
        epsilons=(EPSILONS[0], EPSILONS[-1]),
        usual=usual,  # body angle of the turn of SMALL [rad]
        shorter=shorter,  # and in a SHORTERth of the time
        count=many.count,  # of repeated turns
        # body angle of all of them [rad]
        total=many.count * float(many.single.at(np.array([many.single.rest_time])).heading[0]),
        moved=np.hypot(*moved),  # C until 2 tau [m]
        moved_after=np.hypot(*(later - moved)),
        decay=about["rest_time"] - about["stop_time"],  # time from 2 tau to rest [s]
        shown=SHOWN,
        thousand=THOUSAND,
        radius=manoeuvre.radius,  # [m]
        **held(manoeuvre),
    )


def held(manoeuvre: TurnManoeuvre) -> dict[str, Any]:
    """The largest |w| [m/s^2] that leaves the body at rest: through C; along the circle, from the
    place where it is least to that where it is largest; along a chord of a quarter circle, the
    least; and anywhere within the circle in any direction, which is the least at its rim, as what
    friction can balance is concave in the slider's place."""
    capsule = manoeuvre.capsule
    round_ = np.linspace(0.0, 2.0 * np.pi, PLACES, endpoint=False)
    rim = manoeuvre.radius * np.exp(1j * round_)
    limits = np.array([[holding_limit(capsule, at, to) for to in round_] for at in rim])
    across = PLACES // 4
    number = np.arange(PLACES)
    across_quarter = limits[number, (number + across + across // 2) % PLACES]
    along = limits[number, (number + across) % PLACES]
    return {
        "through_c": capsule.holding_acceleration,
        "along_arc": (float(along.min()), float(along.max())),
        "along_chord": float(across_quarter.min()),
        "anywhere": float(limits.min()),
        # Z of a turn from the places where it turns the body first and last [rad/s^2]
        "turning": (
            float(along.min()) / manoeuvre.radius,
            float(along.max()) / manoeuvre.radius,
        ),
    }


SOURCE = Analysis("capsule_turn/source", numbers)
