"""The force of the slider's actuator: in time, as engines have it, and what sizes an actuator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_motion import Demand
from plumbob.analytic.systems.manoeuvres.driving_force import demand
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import turn_of
from plumbob.analytic.systems.three_points.drive import plane_demand
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.capsule_line.source import STEP, Samples, requests, samples
from plumbob.reports.analyses.claims import Claims, at_most
from plumbob.reports.analyses.measurements import LINE, covers, measured, names, problem

EPSILONS, RADIUS = (0.3, 0.1, 0.03), 0.12  # of turns, and of the slider's circle [m]
WITHIN = 1e-2  # of the force's peak: what theory may leave unpredicted
EVERY = 4  # samples to a mark
NOT_COULOMB = ("pymunk/pivots",)  # three bare joints, whose friction no step brings to Coulomb's


@dataclass(frozen=True)
class ForceError:
    """The error of a method's force on the check manoeuvre [N]."""

    method: str
    largest: float
    unpredicted: float | None
    bound: float | None  # of the model's error


@dataclass(frozen=True)
class DrivingForce:
    """The actuator's force on the line and on turns, and each method's error of it."""

    line: Demand
    turns: Mapping[str, Demand]  # by epsilon
    errors: tuple[ForceError, ...]
    within: float | None  # of the peak: the largest error not predicted where friction converges
    times: Array  # [s]
    forces: Array  # [N], exact
    engines: Mapping[str, Samples]
    step: float = STEP


def numbers(study: Study) -> DrivingForce | None:
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
    return DrivingForce(
        line=wanted,
        turns={str(epsilon): _of_turn(epsilon) for epsilon in EPSILONS},
        errors=errors,
        within=max(unpredicted, default=None),
        times=np.repeat(edges, 2)[1:-1],
        forces=np.repeat(line.driving_force(0.5 * (edges[1:] + edges[:-1])), 2),
        engines=samples(study, EVERY, ("driving_force",)),
    )


def _errors(study: Study) -> Sequence[ForceError]:
    by_method = list[ForceError]()
    for name in names(study):
        run = measured(study, LINE, name, STEP)
        if run and (error := run.errors.get("driving_force")) is not None:
            unpredicted = error.predicted.beyond if error.predicted else None
            bound = error.model_error if error.model else None
            by_method.append(ForceError(name, error.largest, unpredicted, bound))
    return by_method


def _of_turn(epsilon: float) -> Demand:
    manoeuvre = turn_of(problem(LINE).setup.capsule, RADIUS, epsilon)
    return plane_demand(three_point_motion(manoeuvre.capsule, manoeuvre.path))


def claims(numbers: DrivingForce) -> Claims:
    """Theory predicts the force where friction converges."""
    if numbers.within is None:
        return ()
    text = "the distance from the predicted force, over its peak,"
    return (at_most(text, numbers.within, WITHIN),)


DRIVE = Analysis("capsule_line/drive", numbers, requests, claims)
