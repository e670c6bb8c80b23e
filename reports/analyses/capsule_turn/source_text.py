"""Further statements of the source on turns, each computed from the exact motion."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.analytic.systems.three_points.forces import loading
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.analytic.systems.three_points.rest import holding_limit
from plumbob.models.tripod_capsule.turn import TURN_EPSILONS
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_turn.course import exact_course
from plumbob.reports.analyses.capsule_turn.turns import check_turn, facts, scene_name
from plumbob.reports.analyses.measurements import problem

VISIBLE_EPSILON = 0.3  # epsilon at which the effect of friction is visible
# epsilon of a turn; factor by which its time is shortened
SMALL_EPSILON, TURN_TIME_FACTOR = 0.03, 10.0
THOUSAND = "capsule-turn/thousand"
CIRCLE_POSITIONS = 24  # positions around the circle
TURN_NODES = 32  # Gauss points of a smooth segment


def friction_effects(
    manoeuvre: TurnManoeuvre, motion: ThreePointMotion
) -> tuple[float, float, complex]:
    """Returns three effects of friction while the slider moves: the largest |R| of eq. 24 over R_0,
    the integral of R over time [rad/s], and the change of the combined centre's velocity [m/s].

    By eq. 24, the integral is the body's angular velocity at 2 tau, since the slider has
    stopped."""
    x, weights = np.polynomial.legendre.leggauss(TURN_NODES)
    largest = 0.0
    angular_velocity = 0.0
    velocity = 0j
    stop = 2.0 * manoeuvre.half_time * (1.0 - 1e-12)
    for begin, segment in zip(motion.begins, motion.segments, strict=True):
        if begin < stop:
            load = loading(motion, segment, 0.5 * (x + 1.0))
            force, torque = load.friction
            time_weights = 0.5 * weights * load.pace
            acceleration = torque / load.terms.inertia
            world_force = force * np.exp(1j * load.states[:, 4])
            largest = max(largest, float(np.abs(acceleration).max()))
            angular_velocity += float(time_weights @ acceleration)
            velocity += complex(time_weights @ world_force) / motion.body.mass
    return largest / manoeuvre.friction_bound, angular_velocity, velocity


def centre_velocity(manoeuvre: TurnManoeuvre, motion: ThreePointMotion) -> complex:
    """Returns the velocity of the combined centre of mass [m/s] when the slider stops, as vx + i
    vy."""
    end = motion.at(np.array([2.0 * manoeuvre.half_time]))
    arm = motion.body.mass_ratio * complex(*motion.path.end) * np.exp(1j * end.heading[0])
    return complex(complex(*end.velocity[0]) + 1j * end.angular_velocity[0] * arm)


def shortened_turn() -> tuple[float, float]:
    """Returns the body angles [rad] at the ends, 2 tau, of two turns: the turn with epsilon
    SMALL_EPSILON, and a turn in which the slider takes the same path in 1/TURN_TIME_FACTOR of the
    time."""
    manoeuvre = check_turn(SMALL_EPSILON)
    shorter = replace(manoeuvre, half_time=manoeuvre.half_time / TURN_TIME_FACTOR)
    motion = three_point_motion(shorter.capsule, shorter.path)
    end = motion.at(np.array([2.0 * shorter.half_time]))
    return facts(SMALL_EPSILON)["body_angle"], float(end.heading[0])


def numbers() -> Record:
    """Returns the numbers of the exact motion for each statement. A number that states no epsilon
    belongs to the turn with epsilon VISIBLE_EPSILON."""
    manoeuvre = check_turn(VISIBLE_EPSILON)
    motion = problem(scene_name(VISIBLE_EPSILON)).motion.single
    known = facts(VISIBLE_EPSILON)
    velocity = centre_velocity(manoeuvre, motion)
    at_stop, at_rest = exact_course(
        VISIBLE_EPSILON, np.array([2.0, known["rest_time"] / manoeuvre.half_time])
    )[1]
    many = problem(THOUSAND).motion
    friction, integral, velocity_by_friction = friction_effects(manoeuvre, motion)
    usual, shorter = shortened_turn()
    rate = known["angular_velocity_at_stop"]
    momentum_residual = abs(velocity_by_friction / velocity - 1.0)
    return Record(
        # largest relative residual of the balances of momentum and angular momentum until the time
        # 2 tau
        imbalance=max(momentum_residual, abs(integral / rate - 1.0)),
        friction=friction,  # largest friction force |R|, divided by its limit R_0
        integral=integral,  # [rad/s] integral of R until 2 tau
        rate=rate,  # [rad/s] angular velocity of the body at 2 tau
        gap=abs(integral / rate - 1.0),
        # [rad] body angles at 2 tau for the largest and the smallest epsilon
        ends=[
            facts(epsilon)["body_angle"] for epsilon in (TURN_EPSILONS[0], TURN_EPSILONS[-1])
        ],
        epsilons=(TURN_EPSILONS[0], TURN_EPSILONS[-1]),
        usual=usual,  # [rad] body angle of the turn with epsilon SMALL_EPSILON
        shorter=shorter,  # [rad] body angle of the shortened turn
        count=many.count,  # number of repeated turns
        # [rad] body angle after all repeated turns
        total=many.count * float(many.single.at(np.array([many.single.rest_time])).heading[0]),
        moved=np.hypot(*at_stop),  # [m] displacement of C until 2 tau
        moved_after=np.hypot(*(at_rest - at_stop)),  # [m] displacement of C from 2 tau to rest
        decay=known["rest_time"] - known["stop_time"],  # [s] time from 2 tau to rest
        shown=VISIBLE_EPSILON,
        thousand=THOUSAND,
        radius=manoeuvre.radius,  # [m]
        **holding_limits(manoeuvre),
    )


def holding_limits(manoeuvre: TurnManoeuvre) -> dict[str, Any]:
    """Returns the largest slider accelerations |w| [m/s^2] that leave the body at rest.

    `through_c` is for a line through C. `along_arc` is for the circle: the smallest and the largest
    over the positions on it. `along_chord` is for a chord of a quarter circle: the smallest.
    `anywhere` is the smallest for any position within the circle and any direction; it lies on the
    rim, because the acceleration that friction can balance is concave in the slider's position.
    `turning` are the angular accelerations [rad/s^2] that belong to `along_arc`."""
    capsule = manoeuvre.capsule
    angles = np.linspace(0.0, 2.0 * np.pi, CIRCLE_POSITIONS, endpoint=False)
    rim = manoeuvre.radius * np.exp(1j * angles)
    # [m/s^2] by position on the rim and direction of w, shape (CIRCLE_POSITIONS, CIRCLE_POSITIONS)
    limits = np.array([[holding_limit(capsule, at, to) for to in angles] for at in rim])
    quarter = CIRCLE_POSITIONS // 4
    number = np.arange(CIRCLE_POSITIONS)
    # The tangent is 90 degrees from the radius. The chord of a quarter circle is 135 degrees from
    # it.
    across_quarter = limits[number, (number + quarter + quarter // 2) % CIRCLE_POSITIONS]
    along = limits[number, (number + quarter) % CIRCLE_POSITIONS]
    return {
        "through_c": capsule.holding_acceleration,
        "along_arc": (float(along.min()), float(along.max())),
        "along_chord": float(across_quarter.min()),
        "anywhere": float(limits.min()),
        # [rad/s^2] Z at which a turn first moves the body, at the weakest and the strongest
        # position
        "turning": (
            float(along.min()) / manoeuvre.radius,
            float(along.max()) / manoeuvre.radius,
        ),
    }


TURN_SOURCE_TEXT = Analysis("capsule_turn/source", exact=numbers)
