"""Eq. 31 over a whole turn, and the source's Fig. 3: angles over time, and the path of C."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_turn.turns import check_turn, scene_name
from plumbob.reports.analyses.measurements import problem

COURSE_EPSILONS = (0.3, 0.1, 0.03)
# epsilon of the figures, at which the effect of friction is visible
DRAWN_EPSILON = COURSE_EPSILONS[0]
# points of a curve; duration in units of the half time tau
COURSE_POINTS, CURVE_HALF_TIMES = 400, 3.0
PHASES = np.linspace(0.0, CURVE_HALF_TIMES, COURSE_POINTS)  # times in units of tau


def exact_course(epsilon: float, phases: Array) -> tuple[Array, Array]:
    """Returns the heading psi [rad], shape (n,), and the position of C [m], shape (n, 2), of the
    exact motion at the times `phases` in units of tau, shape (n,)."""
    pose = problem(scene_name(epsilon)).motion.single.at(phases * check_turn(epsilon).half_time)
    return pose.heading, pose.position


def leading_path(manoeuvre: TurnManoeuvre, phases: Array) -> Array:
    """Returns the position of C [m] to leading order, shape (n, 2), at the times `phases` in units
    of tau: C moves around the combined centre of mass, which stays at rest."""
    times = phases * manoeuvre.half_time
    arm = manoeuvre.capsule.mass_ratio * manoeuvre.radius * np.exp(1j * manoeuvre.start)
    angles = manoeuvre.slider_angles(times) + manoeuvre.body_angles(times)
    positions = arm - arm * np.exp(1j * angles)
    return np.column_stack([positions.real, positions.imag])


def heading_difference(epsilon: float, phases: Array) -> Array:
    """Returns the difference psi + mu_1 phi [rad] between the exact heading and eq. 31, shape (n,),
    at the times `phases` in units of tau."""
    formula = check_turn(epsilon).body_angles(phases * check_turn(epsilon).half_time)
    return exact_course(epsilon, phases)[0] - formula


def departure(epsilon: float) -> Record:
    """Returns the difference between exact motion and formula over the turn: its largest value, the
    time of that, and its ratio to epsilon^2."""
    phases = np.linspace(0.0, 2.0, COURSE_POINTS + 1)
    magnitudes = np.abs(heading_difference(epsilon, phases))
    scaled = heading_difference(epsilon, PHASES) / epsilon**2
    largest = float(magnitudes.max())
    return Record(
        epsilon=epsilon,
        largest=largest,  # [rad] largest |psi + mu_1 phi| for times in (0, 2 tau)
        time=phases[
            np.argmax(magnitudes)
        ],  # time at which `largest` is reached, divided by tau
        scaled=scaled,  # [rad] (psi + mu_1 phi) / epsilon^2 at PHASES
        coefficient=largest / epsilon**2,
    )


def numbers() -> Record:
    """Returns the departures from the formula for each epsilon, and the angles and paths of the
    turn in the figures."""
    manoeuvre = check_turn(DRAWN_EPSILON)
    times = PHASES * manoeuvre.half_time
    angles, positions = exact_course(DRAWN_EPSILON, PHASES)
    return Record(
        departures=[departure(epsilon) for epsilon in COURSE_EPSILONS],
        phases=PHASES,  # times of all curves, divided by tau
        slider=manoeuvre.slider_angles(times),  # [rad] phi
        formula=manoeuvre.body_angles(times),  # [rad] -mu_1 phi
        exact=angles,  # [rad] psi
        path=1e3 * positions.T,  # [mm] path of C, shape (2, n)
        # [mm] path of C without friction, shape (2, n)
        leading=1e3 * leading_path(manoeuvre, np.minimum(PHASES, 2.0)).T,
        drawn=DRAWN_EPSILON,
    )


TURN_COURSE = Analysis("capsule_turn/course", exact=numbers)
