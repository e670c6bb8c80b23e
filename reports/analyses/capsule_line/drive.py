"""The force of the slider's actuator: in time, as engines have it, and what sizes an actuator."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.analytic.systems.capsule_motion import Demand
from plumbob.analytic.systems.manoeuvres.driving_force import demand
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import turn_of
from plumbob.analytic.systems.three_points.drive import plane_demand
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_line.source import STEP, requests, samples
from plumbob.reports.analyses.claims import Claims, at_most
from plumbob.reports.analyses.measurements import LINE, covers, measured, names, problem

EPSILONS, RADIUS = (0.3, 0.1, 0.03), 0.12  # of turns, and of the slider's circle [m]
WITHIN = 1e-2  # of the force's peak: what theory may leave unpredicted
EVERY = 4  # samples to a mark
NOT_COULOMB = ("pymunk/pivots",)  # three bare joints, whose friction no step brings to Coulomb's


def numbers(study: Study) -> Record | None:
    """Demands and errors; None where the study does not have the scene."""
    if not covers(study, LINE):
        return None
    line = problem(LINE).motion
    wanted = demand(line, line.t2)
    errors = tuple(_errors(study))
    unpredicted = [
        error.unpredicted / wanted.peak
        for error in errors
        if error.bound is not None
        and error.unpredicted is not None
        and error.method not in NOT_COULOMB
    ]
    edges = np.array([0.0, line.t1, line.t_star, line.t2, 1.05 * line.t2])
    return Record(
        line=wanted,
        turns={str(epsilon): _of_turn(epsilon) for epsilon in EPSILONS},  # by epsilon
        errors=errors,
        # of the peak: the largest error not predicted where friction converges
        within=max(unpredicted, default=None),
        times=np.repeat(edges, 2)[1:-1],  # [s]
        forces=np.repeat(line.driving_force(0.5 * (edges[1:] + edges[:-1])), 2),  # [N], exact
        engines=samples(study, EVERY, ("driving_force",)),
        step=STEP,
    )


def _errors(study: Study) -> Sequence[Record]:
    """The error of a method's force on the check manoeuvre [N]."""
    by_method = list[Record]()
    for name in names(study):
        run = measured(study, LINE, name, STEP)
        if run and (error := run.errors.get("driving_force")) is not None:
            unpredicted = error.predicted.beyond if error.predicted else None
            bound = error.model_error if error.model else None
            by_method.append(
                Record(
                    method=name,
                    largest=error.largest,
                    unpredicted=unpredicted,
                    bound=bound,  # of the model's error
                )
            )
    return by_method


def _of_turn(epsilon: float) -> Demand:
    manoeuvre = turn_of(problem(LINE).setup.capsule, RADIUS, epsilon)
    return plane_demand(three_point_motion(manoeuvre.capsule, manoeuvre.path))


def claims(numbers: Record) -> Claims:
    """Theory predicts the force where friction converges."""
    if numbers.within is None:
        return ()
    text = "the distance from the predicted force, over its peak,"
    return (at_most(text, numbers.within, WITHIN),)


DRIVE = Analysis("capsule_line/drive", numbers, requests, claims)
