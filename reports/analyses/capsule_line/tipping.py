"""The slider positions that keep all supports in contact, and a run that leaves them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.analytic.systems.capsule import lowest_normal_forces, source_assumption
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.measurements import LINE, covers, problem

EDGE, METHOD, STEP, LASTING = "capsule-line/near-edge", "mujoco/euler+coulomb", 2e-4, 0.3  # [s]
BEYOND = 0.005  # [m] distance by which the slider starts further along its line than in EDGE
TIPPED = ExtraRun(EDGE, METHOD, STEP, LASTING, settings=(("slider_ahead", BEYOND),))
# The supports of the check body are moved until C is 1 cm outside their triangle. The slider starts
# far enough ahead to keep the body in contact.
OUTSIDE = (("supports", ((0.31, 0.0), (0.01, 0.15), (0.01, -0.15))), ("start", 0.1))


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Returns the run of a manoeuvre that ends beyond the edge, if the plan has the check
    manoeuvre."""
    return (TIPPED,) if covers(plan, LINE) else ()


def numbers(study: Study) -> Record | None:
    """Returns the contact conditions of three motions, and the lift of a foot in the run beyond the
    edge; None if the study lacks the check manoeuvre."""
    if not covers(study, LINE):
        return None
    check = problem(LINE).motion
    edge = problem(EDGE).motion
    outside = case_of(find_scene(LINE, dict(OUTSIDE))).problem.motion
    return Record(
        # ratio of the slider's allowed distance from C to the triangle's
        reach=1.0 / problem(LINE).setup.capsule.mass_ratio,
        check=_contact_condition(check),
        edge=_contact_condition(edge),
        outside=_contact_condition(outside),  # motion with C outside the triangle
        lift=_lift(study),
        beyond=BEYOND,
    )


def _contact_condition(motion: LineManoeuvre) -> Record:
    """Returns whether a motion satisfies the source's assumptions (centre of mass and slider inside
    the triangle), and its smallest normal force over the weight."""
    lowest, _ = lowest_normal_forces(motion.capsule, motion.ends)
    assumed = source_assumption(motion.capsule, motion.ends)
    return Record(
        com_inside=assumed.com_inside,
        slider_inside=assumed.slider_inside,
        lowest=float(np.min(lowest)) / motion.capsule.weight,
    )


def _lift(study: Study) -> Record | None:
    """Returns the time [s] at which a foot leaves the plane, and the height [m] to which C rises by
    the end [s]; None if the run is missing or no foot lifts."""
    run = study.answer(TIPPED)
    if run is None:
        return None
    lifted = run.times[run.channels["contacts"] < 3]
    if not lifted.size:
        return None
    height = float(run.channels["vertical_displacement"][-1])
    return Record(time=lifted[0], risen=height, end=run.times[-1])


TIPPING = Analysis("capsule_line/tipping", numbers, requests)
