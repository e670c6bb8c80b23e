"""Contact settings that give a ball half of its speed back, and their error at a step of 1 ms."""

from __future__ import annotations

import math
from collections.abc import Sequence

from plumbob.analytic.errors.contact_models.impacts import damping_ratio, soft_impact
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of, scene
from plumbob.reports.analyses.analysis import Analysis, Record, Section
from plumbob.reports.analyses.claims import at_most
from plumbob.reports.analyses.measurements import plan_of, recordings
from plumbob.reports.view.content import Claim

STEP = 1e-3  # [s]
METHODS = ("mujoco/euler", "mujoco/rk4", "pymunk/contact")
RESTITUTIONS = (1.0, 0.9, 0.75, 0.5, 0.25, 0.1)
RUNS = tuple(ExtraRun("bouncing-ball/half", method, STEP, duration=0.9) for method in METHODS)


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Returns a run past the first rebound for each of METHODS in the plan."""
    return [run for run in RUNS if plan.has(run.scene, run.method)]


def numbers(study: Study) -> Record | None:
    """Returns the coefficients of restitution that the methods reach, and the contact settings for
    other coefficients; None if no method was run."""
    measured = {}
    ball = case_of(scene(RUNS[0].scene)).problem
    for request, run in recordings(study, requests(plan_of(study))).items():
        top = run.observables["z"][run.times > ball.fall].max()
        measured[request.method] = math.sqrt(float(top) / ball.height)
    if not measured:
        return None
    contacts = [(e, damping_ratio(e), *soft_impact(e, STEP).solref) for e in RESTITUTIONS]
    return Record(
        restitution=ball.restitution,
        step=STEP,  # [s]
        measured=measured,
        contacts=contacts,  # e, damping ratio, solref
        # change of e if the damper acts half a step late
        late=ball.restitution * soft_impact(ball.restitution, STEP).damping * STEP / 2.0,
    )


def claims(rebounds: Record) -> Sequence[Claim]:
    """Returns the checks that the error of each restitution is at most the effect of half a
    step."""
    return [
        at_most(f"the error of e with {name}", abs(e - rebounds.restitution), rebounds.late)
        for name, e in rebounds.measured.items()
    ]


SECTION = Section((Analysis("bouncing_ball/restitution", numbers, requests, claims=claims),))
