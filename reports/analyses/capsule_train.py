"""Repeated manoeuvres: the accumulated errors, and the cost of one manoeuvre."""

from __future__ import annotations

from plumbob.analytic.systems.manoeuvres.repeated_line import RepeatedLine
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record, Section
from plumbob.reports.analyses.claims import Claims, at_most
from plumbob.reports.analyses.mean_speed import MEAN_SPEED
from plumbob.reports.analyses.measurements import (
    covers,
    find_measurement,
    method_names,
    problem,
)

SCENES = ("capsule-train/thousand", "capsule-train/ten")  # the first one that was run is used
COMPARED_STEP = 1e-3  # [s]
GOOD = 1e-3  # relative error of a method whose contacts converge


def numbers(study: Study) -> Record | None:
    """Returns the total displacement of each method beside the exact one (the count of manoeuvres
    times eq. 22), and the cost of a manoeuvre; None if no method ran."""
    scene = next((name for name in SCENES if covers(study, name)), None)
    if scene is None:
        return None
    repeated: RepeatedLine = problem(scene).motion
    by_method = [_total(study, scene, repeated, name) for name in method_names(study)]
    totals = tuple(total for total in by_method if total)
    if not totals:
        return None
    sizes = sorted(abs(total.error) for total in totals)
    return Record(
        scene=scene,
        totals=totals,
        count=repeated.count,
        displacement=repeated.displacement,  # [m] exact, by all manoeuvres
        once=repeated.manoeuvre.displacement,  # [m] exact, by one manoeuvre
        fraction=repeated.fraction,  # fraction of the friction limit used by the slow return
        period=repeated.period,  # [s]
        step=COMPARED_STEP,
        duration=repeated.count * repeated.period,  # [s] all manoeuvres
        sizes=sizes,  # magnitudes of the relative errors, in ascending order
        within=[size for size in sizes if size <= GOOD],
        beyond=[size for size in sizes if size > GOOD],
    )


def _total(study: Study, scene: str, repeated: RepeatedLine, method: str) -> Record | None:
    """Returns a method's total displacement, its relative error, and the cost of one manoeuvre;
    None if the method did not run."""
    run = find_measurement(study, scene, method, COMPARED_STEP)
    if run is None:
        return None
    error = run.errors["displacement"]
    exact = repeated.displacement
    timed = study.costs.get((scene, method))
    return Record(
        method=method,
        displacement=exact + error.end,  # [m]
        error=error.end / exact,
        predicted=error.predicted.end / exact if error.predicted else None,
        # [s] of wall time
        cost=timed.ns_per_step * 1e-9 * run.steps / repeated.count if timed else None,
    )


def claims(totals: Record) -> Claims:
    """Returns the checks that one method is accurate, and that theory predicts the accumulated
    error of every method whose contacts converge."""
    checks = [at_most("the smallest relative error", totals.sizes[0], GOOD)]
    for total in totals.totals:
        if total.predicted is not None and abs(total.error) <= GOOD:
            text = f"what theory leaves of the relative error of {total.method}"
            checks.append(at_most(text, total.error - total.predicted, GOOD))
    return checks


TOTAL = Analysis("capsule_train/total", numbers, claims=claims)
SECTION = Section((TOTAL, MEAN_SPEED))
