"""The exact motion as a generating solution: perturbation theory for a weak drive."""

from __future__ import annotations

from plumbob.analytic.errors.contact_models.added_inertia import drive_error
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, at_most
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    FULL_MODEL_METHOD,
    FULL_MODEL_STEP,
    ROTATING,
    closed_forms,
)

INERTIAS = (1e3, 1e4, 1e5)  # [kg m^2] armatures of the platform's joint
PLATFORM_INERTIA = 1.0  # [kg m^2] inertia of the platform in the model file
DRIVE_RATE, DRIVE_TIME = 5.0, 2.0  # [1/s] rate of the servo, [s] duration of the runs
LARGEST_BODY_INERTIA = 1.7  # [kg m^2] largest inertia of the body about the platform's axis


def _drive_run(inertia: float) -> ExtraRun:
    """Returns MuJoCo's run with a weak drive of a platform with an armature [kg m^2]."""
    settings = (("platform_armature", inertia), ("drive_rate", DRIVE_RATE))
    return ExtraRun(ROTATING, FULL_MODEL_METHOD, FULL_MODEL_STEP, DRIVE_TIME, (), settings)


def _deviation(run: Trajectory, inertia: float) -> Record:
    """Returns the deviation of theta from the motion with an ideal drive, at the end of a run with
    a weak drive, measured and predicted to first order."""
    problem = closed_forms(ROTATING).problem
    # The servo's gain is DRIVE_RATE times the armature, but it also moves the platform's own
    # inertia.
    rate = DRIVE_RATE * inertia / (inertia + PLATFORM_INERTIA)
    predicted = drive_error(problem, run.times, inertia + PLATFORM_INERTIA, rate).theta[-1]
    ideal = problem.reference.state(run.times)[0]
    measured = (run.observables["theta"] - ideal)[-1]
    return Record(
        inertia=inertia,  # [kg m^2] armature of the platform's joint
        apart=measured,  # [rad] measured deviation
        first=predicted,  # [rad] deviation predicted to first order
        gap=measured / predicted - 1.0,  # relative difference of both
    )


def numbers(study: Study) -> Record:
    """Returns the deviations by weak drives, beside first-order perturbation theory."""
    runs = [(study.answer(_drive_run(inertia)), inertia) for inertia in INERTIAS]
    return Record(
        drives=[_deviation(run, inertia) for run, inertia in runs if run],
        drive_rate=DRIVE_RATE,
        drive_time=DRIVE_TIME,
    )


def claims(solutions: Record) -> Claims:
    """Returns the checks that each difference from first order is at most the second-order term,
    the ratio of the body's inertia to the platform's."""
    what = "the relative difference from first order, times the platform's inertia,"
    return [
        at_most(what, drive.gap * drive.inertia, LARGEST_BODY_INERTIA, "kg m²")
        for drive in solutions.drives
    ]


GENERATING_SOLUTION = Analysis(
    "cone_pendulum/generating_solution",
    numbers,
    lambda plan: tuple(map(_drive_run, INERTIAS)),
    claims,
)
