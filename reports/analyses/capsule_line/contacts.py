"""Contacts: chatter of the default ones, and normal forces."""

from __future__ import annotations

import numpy as np

from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, at_most, clear
from plumbob.reports.analyses.measurements import (
    LINE,
    case,
    end_error,
    problem,
    recordings,
    runs,
    scheme,
)

LOADS = tuple(f"normal_force_{i}" for i in (1, 2, 3))
DEFAULT, CONVERGENT = "mujoco/euler", "mujoco/euler+coulomb"
STEPS = (1e-3, 1e-4)  # [s]; the figures are at the finer one
FLOOR = 1e-14  # [m] where a vertical displacement of zero is drawn
STATICS, STATICS_STEP = "capsule-line/at-123", 1e-4
STATICS_METHODS = ("mujoco/euler+coulomb", "pymunk/side")
CHATTERS = 1e-3  # of the samples: a contact is missing in many times that
TRUSTED = 1e-3  # of a normal force: what is nearer to statics can be trusted
SETTLED = 60  # steps: contacts of damping 0.3 have come to rest
CHATTER_RUNS = runs((LINE,), (DEFAULT, CONVERGENT), STEPS)
LOAD_RUNS = runs((STATICS,), STATICS_METHODS, (STATICS_STEP,))


def chatter(study: Study) -> Record | None:
    """Vertical displacement, contacts and normal force over time, default against convergent; None
    where one did not run."""
    by_request = recordings(study, CHATTER_RUNS)
    if len(by_request) < len(CHATTER_RUNS):
        return None
    return Record(contacts=[_contacts(request, run) for request, run in by_request.items()])


def _contacts(request: ExtraRun, run: Trajectory) -> Record:
    """How the contacts of a method behave at a step."""
    motion = problem(LINE).motion
    height = run.channels["vertical_displacement"]
    contacts = run.channels["contacts"]
    return Record(
        method=request.method,
        step=request.step,  # [s]
        error=end_error(LINE, run),  # of the displacement, relative
        vertical_range=np.ptp(height),  # [m]
        # fraction of samples with a contact missing while the body slides
        missing=np.mean(contacts[run.times < motion.t_star] < 3),
        times=run.times,  # [s], of the rows below
        heights=np.maximum(np.abs(height), FLOOR),  # [m], above zero
        contacts=contacts,
        # sum of normal forces over the weight
        loads=np.sum([run.observables[load] for load in LOADS], axis=0) / motion.capsule.weight,
    )


def _chatters(numbers: Record) -> Claims:
    _, default, _, convergent = numbers.contacts
    text = "errors with default contacts, and with those that converge"
    missing = "the part of samples with a contact missing, and 0.001"
    return (
        clear(text, default.error, convergent.error),
        clear(missing, default.missing, CHATTERS),
    )


def loads(study: Study) -> Record | None:
    """Normal forces at rest, while the slider moves, and with half a step of its motion allowed."""
    by_request = recordings(study, LOAD_RUNS)
    engines = tuple(_load_errors(request.method, run) for request, run in by_request.items())
    return (
        Record(
            engines=engines,
            at_rest=max(engine.at_rest for engine in engines),  # the largest of all
            step=STATICS_STEP,
        )
        if engines
        else None
    )


def _load_errors(method: str, run: Trajectory) -> Record:
    """Relative distances of a method's normal forces from statics, the largest of the three."""
    exact = case(STATICS).reference.observe(run.times)
    predicted = case(STATICS).errors.at_step(scheme(method), STATICS_STEP, run.times).errors
    measured, truth, lead = (
        np.stack([source[load] for load in LOADS])
        for source in (run.observables, exact, predicted)
    )
    distances = np.abs(measured / truth - 1.0).max(axis=0)
    half_step = np.abs((measured - lead) / truth - 1.0).max(axis=0)
    settled = run.times > problem(STATICS).motion.t2 + SETTLED * STATICS_STEP
    return Record(
        method=method,
        at_rest=distances[settled].max(),  # the largest after the motion
        largest=distances.max(),  # of all times
        half_step=half_step[:-1].max(),  # with the predicted error of the step
    )


def _statics(numbers: Record) -> Claims:
    text = "the largest distance from statics at rest, relative,"
    return (at_most(text, numbers.at_rest, TRUSTED),)


CHATTER = Analysis("capsule_line/chatter", chatter, lambda plan: CHATTER_RUNS, _chatters)
LOAD_ERRORS = Analysis("capsule_line/loads", loads, lambda plan: LOAD_RUNS, _statics)
