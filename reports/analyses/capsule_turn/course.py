"""Eq. 31 over the whole of a turn, and the source's Fig. 3: angles in time, and the path of C."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_turn.turns import name_of, turn
from plumbob.reports.analyses.measurements import problem

EPSILONS = (0.3, 0.1, 0.03)
DRAWN = EPSILONS[0]  # of the figures: friction is seen there
POINTS, LASTING = 400, 3.0  # of a curve, and half times
PHASES = np.linspace(0.0, LASTING, POINTS)  # times over tau


def exact_course(epsilon: float, phases: Array) -> tuple[Array, Array]:
    """psi [rad], shape (n,), and the place of C [m], shape (n, 2), of the exact motion at times
    `phases` tau, shape (n,)."""
    pose = problem(name_of(epsilon)).motion.single.at(phases * turn(epsilon).half_time)
    return pose.heading, pose.position


def leading_path(manoeuvre: TurnManoeuvre, phases: Array) -> Array:
    """Place of C [m], shape (n, 2), to leading order: it goes round the combined centre, which
    stays where it is."""
    times = phases * manoeuvre.half_time
    arm = manoeuvre.capsule.mass_ratio * manoeuvre.radius * np.exp(1j * manoeuvre.start)
    moved = arm - arm * np.exp(
        1j * (manoeuvre.slider_angles(times) + manoeuvre.body_angles(times))
    )
    return np.column_stack([moved.real, moved.imag])


def difference(epsilon: float, phases: Array) -> Array:
    """psi + mu_1 phi [rad] at times `phases` tau."""
    formula = turn(epsilon).body_angles(phases * turn(epsilon).half_time)
    return exact_course(epsilon, phases)[0] - formula


def departure(epsilon: float) -> Record:
    """The difference over the turn, and where it is the largest."""
    phases = np.linspace(0.0, 2.0, POINTS + 1)
    off = np.abs(difference(epsilon, phases))
    scaled = difference(epsilon, PHASES) / epsilon**2
    largest = float(off.max())
    return Record(
        epsilon=epsilon,
        largest=largest,  # |psi + mu_1 phi| over (0, 2 tau) [rad]
        time=phases[np.argmax(off)],  # of it, over tau
        scaled=scaled,  # psi + mu_1 phi over epsilon^2 [rad]
        coefficient=largest / epsilon**2,
    )


def numbers(study: Study) -> Record:
    """Angles and paths of the turn that is drawn."""
    manoeuvre = turn(DRAWN)
    times = PHASES * manoeuvre.half_time
    angles, place = exact_course(DRAWN, PHASES)
    return Record(
        departures=[departure(epsilon) for epsilon in EPSILONS],
        phases=PHASES,  # times of all curves, over tau
        slider=manoeuvre.slider_angles(times),  # phi [rad]
        formula=manoeuvre.body_angles(times),  # -mu_1 phi [rad]
        exact=angles,  # psi [rad]
        path=1e3 * place.T,  # of C [mm], shape (2, n)
        # the same without friction
        leading=1e3 * leading_path(manoeuvre, np.minimum(PHASES, 2.0)).T,
        drawn=DRAWN,
    )


COURSE = Analysis("capsule_turn/course", numbers)
