"""Where the slider may go: the exact condition for contact, and what is beyond it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import lowest_normal_forces, normal_forces, source_assumption
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_line.source import Samples
from plumbob.reports.analyses.measurements import LINE, covers, problem, recordings

EDGE, METHOD, STEP, LASTING = "capsule-line/near-edge", "mujoco/euler+coulomb", 2e-4, 0.3  # [s]
BEYOND = 0.005  # [m] that the slider starts further along its line than in EDGE
INSIDE = ExtraRun(EDGE, METHOD, STEP, LASTING)
TIPPED = ExtraRun(EDGE, METHOD, STEP, LASTING, settings=(("slider_ahead", BEYOND),))
# The triangle of the check body moved until C is 1 cm outside; the slider starts far enough ahead.
OUTSIDE = (("supports", ((0.31, 0.0), (0.01, 0.15), (0.01, -0.15))), ("start", 0.1))
ENGINES = (METHOD, "pymunk/side")
ENGINE_STEP = 1e-3  # [s]
OUTSIDE_RUNS = tuple(ExtraRun(LINE, method, ENGINE_STEP, changes=OUTSIDE) for method in ENGINES)
DRAWN = 0.2  # [s]


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """A manoeuvre that ends inside the edge and one that ends beyond; one with C outside."""
    if not covers(plan, LINE):
        return ()
    return (INSIDE, TIPPED, *OUTSIDE_RUNS)


def loads_beyond(times: Array) -> Array:
    """N_i [N], shape (n, 3), that statics asks for at `times` [s] in the run that tips: below
    zero, which a plane that only pushes cannot give."""
    line = problem(EDGE).motion
    places = (line.start + BEYOND + line.strokes(times))[:, None] * line.unit
    return normal_forces(line.capsule, places)


def numbers(study: Study) -> Record | None:
    """The exact condition and the runs about it; None where the study does not have the check
    manoeuvre."""
    if not covers(study, LINE):
        return None
    check, edge = problem(LINE).motion, problem(EDGE).motion
    outside = case_of(find_scene(LINE, dict(OUTSIDE))).problem.motion
    exact = float(outside.displacement)
    by_request = recordings(study, OUTSIDE_RUNS)
    times = np.linspace(0.0, DRAWN, 200)
    return Record(
        # of the slider from C, over the triangle's
        reach=1.0 / problem(LINE).setup.capsule.mass_ratio,
        check=_motion(check),
        edge=_motion(edge),
        outside=_motion(outside),  # C outside the triangle
        displacement=exact,  # [m], with C outside
        # of engines, relative, with C outside
        errors={
            request.method: float(run.observables["displacement"][-1]) / exact - 1.0
            for request, run in by_request.items()
        },
        lift=_lift(study),
        times=times,  # [s]
        exact=edge.normal_forces(times)[:, 0],  # normal force at A1 [N], inside the edge
        statics=loads_beyond(times)[:, 0],  # beyond
        inside=_load(study, INSIDE),  # in MuJoCo
        tipped=_load(study, TIPPED),
        step=ENGINE_STEP,
        beyond=BEYOND,
    )


def _motion(motion: LineManoeuvre) -> Record:
    """Whether a motion is as the source assumes, and its smallest normal force over the weight."""
    lowest, _ = lowest_normal_forces(motion.capsule, (motion.segment,))
    assumed = source_assumption(motion.capsule, (motion.segment,))
    smallest = float(np.min(lowest)) / motion.capsule.weight
    return Record(
        com_inside=assumed.com_inside, slider_inside=assumed.slider_inside, lowest=smallest
    )


def _lift(study: Study) -> Record | None:
    """When a foot leaves the plane [s], and how far C has risen [m] at the end [s]."""
    if (run := study.answer(TIPPED)) is None:
        return None
    off = run.times[run.channels["contacts"] < 3]
    risen = float(run.channels["vertical_displacement"][-1])
    return Record(time=off[0], risen=risen, end=run.times[-1]) if off.size else None


def _load(study: Study, request: ExtraRun) -> Samples | None:
    if (run := study.answer(request)) is None:
        return None
    kept = run.times <= DRAWN
    return {"times": run.times[kept], "forces": run.observables["normal_force_1"][kept]}


TIPPING = Analysis("capsule_line/tipping", numbers, requests)
