"""Contact chatter with default contacts, and errors of normal forces."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, at_most, clearly_larger
from plumbob.reports.analyses.measurements import (
    CHECK_LINE,
    case,
    end_error,
    extra_runs,
    problem,
    recordings,
    scheme,
)

NORMAL_FORCE_NAMES = tuple(f"normal_force_{i}" for i in (1, 2, 3))
DEFAULT_CONTACT, CONVERGENT_CONTACT = "mujoco/euler", "mujoco/euler+coulomb"
CONTACT_STEPS = (1e-3, 1e-4)  # [s] steps of the runs; the figures show the finer one
DRAWN_ZERO = 1e-14  # [m] value at which a vertical displacement of zero is drawn
STATICS, STATICS_STEP = "capsule-line/at-123", 1e-4
STATICS_METHODS = ("mujoco/euler+coulomb", "pymunk/side")
# Fraction of the samples with a contact missing. If contacts chatter, the fraction is far larger.
CHATTER_FRACTION = 1e-3
TRUSTED_LOAD_ERROR = 1e-3  # largest relative distance from statics of a normal force to trust
# number of steps after which contacts of damping ratio 0.3 have come to rest
SETTLING_STEPS = 60
CHATTER_RUNS = extra_runs((CHECK_LINE,), (DEFAULT_CONTACT, CONVERGENT_CONTACT), CONTACT_STEPS)
LOAD_RUNS = extra_runs((STATICS,), STATICS_METHODS, (STATICS_STEP,))


def chatter(study: Study) -> Record | None:
    """Returns the vertical displacement, the number of contacts and the normal forces over time,
    with default and with convergent contacts; None if a run is missing."""
    by_request = recordings(study, CHATTER_RUNS)
    if len(by_request) < len(CHATTER_RUNS):
        return None
    return Record(contacts=[_contacts(request, run) for request, run in by_request.items()])


def _contacts(request: ExtraRun, run: Trajectory) -> Record:
    """Returns the behaviour of a method's contacts in a run with one step size: the error, missing
    contacts, heights and loads over time."""
    motion = problem(CHECK_LINE).motion
    height = run.channels["vertical_displacement"]
    contacts = run.channels["contacts"]
    return Record(
        method=request.method,
        step=request.step,  # [s]
        error=end_error(CHECK_LINE, run),  # relative error of the displacement
        vertical_range=np.ptp(height),  # [m]
        # fraction of the samples during sliding that have fewer than three contacts
        missing=np.mean(contacts[run.times < motion.t_star] < 3),
        times=run.times,  # [s] times of the following rows
        # [m] magnitudes, at least DRAWN_ZERO for a logarithmic axis
        heights=np.maximum(np.abs(height), DRAWN_ZERO),
        contacts=contacts,
        # ratio of the sum of normal forces to the weight
        loads=np.sum([run.observables[load] for load in NORMAL_FORCE_NAMES], axis=0)
        / motion.capsule.weight,
    )


def _contact_claims(numbers: Record) -> Claims:
    """Returns the checks that default contacts have a larger error than convergent ones, and that
    default contacts are often missing, both at the finest step."""
    rows = {(row.method, row.step): row for row in numbers.contacts}
    default = rows[DEFAULT_CONTACT, CONTACT_STEPS[-1]]
    convergent = rows[CONVERGENT_CONTACT, CONTACT_STEPS[-1]]
    text = "errors with default contacts, and with those that converge"
    missing = f"the part of samples with a contact missing, and {CHATTER_FRACTION:g}"
    return (
        clearly_larger(text, default.error, convergent.error),
        clearly_larger(missing, default.missing, CHATTER_FRACTION),
    )


def loads(study: Study) -> Record | None:
    """Returns the errors of the normal forces in each engine: at rest, at all times, and without
    the predicted error of the step. Returns None if no engine ran."""
    by_request = recordings(study, LOAD_RUNS)
    engines = tuple(_load_errors(request.method, run) for request, run in by_request.items())
    if not engines:
        return None
    return Record(
        engines=engines,
        at_rest=max(engine.at_rest for engine in engines),  # largest of all engines
        step=STATICS_STEP,
    )


def _load_errors(method: str, run: Trajectory) -> Record:
    """Returns the relative distances of a method's normal forces from statics, the largest of the
    three supports."""
    statics = case(STATICS)
    measured = _loads(run.observables)
    exact = _loads(statics.reference.observe(run.times))
    step_errors = _loads(statics.errors.at_step(scheme(method), STATICS_STEP, run.times).errors)
    distances = np.abs(measured / exact - 1.0).max(axis=0)
    half_step = np.abs((measured - step_errors) / exact - 1.0).max(axis=0)
    at_rest = run.times > problem(STATICS).motion.t2 + SETTLING_STEPS * STATICS_STEP
    return Record(
        method=method,
        at_rest=distances[at_rest].max(),  # largest after the motion
        largest=distances.max(),  # largest at any time
        half_step=half_step[:-1].max(),  # largest without the predicted error of the step
    )


def _loads(signals: Signals) -> Array:
    """Returns the normal forces of the three supports, shape (3, n)."""
    return np.stack([signals[load] for load in NORMAL_FORCE_NAMES])


def _agrees_at_rest(numbers: Record) -> Claims:
    """Returns the check that the normal forces at rest agree with statics."""
    text = "the largest distance from statics at rest, relative,"
    return (at_most(text, numbers.at_rest, TRUSTED_LOAD_ERROR),)


CHATTER_ANALYSIS = Analysis(
    "capsule_line/chatter", chatter, lambda plan: CHATTER_RUNS, _contact_claims
)
LOAD_ERRORS = Analysis("capsule_line/loads", loads, lambda plan: LOAD_RUNS, _agrees_at_rest)
