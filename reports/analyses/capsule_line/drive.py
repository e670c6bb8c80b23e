"""The force of the slider's actuator over time, exact and in engines, and the demands on it."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.systems.capsule_motion import Demand
from plumbob.analytic.systems.manoeuvres.driving_force import demand
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import turn_of
from plumbob.analytic.systems.three_points.forces import plane_demand
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_line.source import STEP, requests, samples
from plumbob.reports.analyses.measurements import LINE, covers, problem

EPSILONS = (0.3, 0.1, 0.03)  # epsilons of the turns
RADIUS = 0.12  # [m] radius of the slider's circle
EVERY = 4  # samples per mark in the figure


def numbers(study: Study) -> Record | None:
    """Returns the demands of the line and of turns on an actuator, and its force over time; None if
    the study lacks the scene."""
    if not covers(study, LINE):
        return None
    line = problem(LINE).motion
    edges = np.array([0.0, line.t1, line.t_star, line.t2, 1.05 * line.t2])
    middles = 0.5 * (edges[1:] + edges[:-1])
    return Record(
        line=demand(line, line.t2),
        turns={str(epsilon): _turn_demand(epsilon) for epsilon in EPSILONS},  # by epsilon
        times=np.repeat(edges, 2)[1:-1],  # [s] both ends of each interval of constant force
        forces=np.repeat(line.driving_force(middles), 2),  # [N] exact
        engines=samples(study, EVERY, ("driving_force",)),
        step=STEP,
    )


def _turn_demand(epsilon: float) -> Demand:
    """Returns the demand of a turn on the actuator."""
    manoeuvre = turn_of(problem(LINE).setup.capsule, RADIUS, epsilon)
    return plane_demand(three_point_motion(manoeuvre.capsule, manoeuvre.path))


DRIVE = Analysis("capsule_line/drive", numbers, requests)
