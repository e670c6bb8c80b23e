"""The page's section on repeated manoeuvres: errors that add up, and what a manoeuvre costs."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses import mean_speed
from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.claims import at_most
from plumbob.reports.analyses.measurements import covers, measured, names, problem
from plumbob.reports.view import notation
from plumbob.reports.view.content import (
    Cell,
    Finding,
    Statement,
    Table,
    method_cell,
    row,
    value,
)
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.sources import CHERNOUSKO

SCENES = ("capsule-train/thousand", "capsule-train/ten")  # the longer one, where it was run
STEP = 1e-3  # [s]
GOOD = 1e-3  # relative


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The fastest manoeuvres, with the methods that a study has."""
    if not any(covers(plan, name) for name in SCENES):
        return ()
    planned = {method.name for method in plan.methods}
    return [mean_speed.request(name) for name in mean_speed.METHODS if name in planned]


def total(study: Study) -> Finding | None:
    """Total displacement of each method against count times eq. 22, and cost per manoeuvre; None
    where none ran."""
    scene = next((name for name in SCENES if covers(study, name)), None)
    if scene is None:
        return None
    repeated = problem(scene).motion
    rows, errors, beyond = [], dict[str, float](), dict[str, float]()
    for name in names(study):
        if (run := measured(study, scene, name, STEP)) is None:
            continue
        error = run.errors["displacement"]
        relative = errors[name] = error.end / repeated.displacement
        predicted = error.predicted.end / repeated.displacement if error.predicted else None
        if predicted is not None and abs(relative) <= GOOD:
            beyond[name] = relative - predicted
        timed = study.costs.get((scene, name))
        cost = (
            notation.seconds(timed.ns_per_step * 1e-9 * run.steps / repeated.count)
            if timed
            else "–"
        )
        rows.append(
            row(method_cell(name), value(repeated.displacement + error.end, 6), value(relative),
                value(predicted), Cell(cost, "number"))
        )  # fmt: skip
    if not rows:
        return None
    heads = ("method", "total displacement [m]", "relative error", "predicted", "per manoeuvre")
    return Finding(
        "capsule-train-total",
        "Repeated manoeuvres: the error of one times their number",
        "confirmed",
        "To know the error of a long walk, measure one manoeuvre: the errors add up. "
        f"After {repeated.count} manoeuvres of "
        f"{number(1e3 * repeated.manoeuvre.displacement)} mm{_summary(errors)}.",
        (
            "Each manoeuvre is followed by a slow return of the slider, at "
            f"{number(repeated.fraction)} of the acceleration that friction can hold, and by a "
            "pause so that the next one starts on the grid of steps: "
            f"{number(repeated.period)} s in all. The predicted error of one manoeuvre then "
            "adds up, and nothing else does.",
        ),
        (Table(f"{scene.partition('/')[2]}, step {short(STEP)} s, exact "
               f"{number(repeated.displacement, 6)} m", heads, tuple(rows),
               "Cost: wall time of the stepping alone, of 320 steps."),),
        (),
        ("plumbob validate --profile full --scenes capsule-train/thousand",
         "plumbob run capsule-train/ten mujoco/euler+coulomb --step 1e-3"),
        (Statement(
            CHERNOUSKO, "after (22)", "Repeated, the manoeuvre reaches any distance in finite "
            "time, the slider returning by slow motions", "any distance",
            f"{repeated.count} manoeuvres: {number(repeated.displacement, 6)} m in "
            f"{number(repeated.count * repeated.period, 4)} s; relative errors in "
            f"engines: {number(min(map(abs, errors.values())), 2)} to "
            f"{number(max(map(abs, errors.values())), 2)}", "holds"),),
        claims=(
            at_most("the smallest relative error", min(map(abs, errors.values())), GOOD),
            *(at_most(f"what theory leaves of the relative error of {name}", left, GOOD)
              for name, left in beyond.items()),
        ),
    )  # fmt: skip


def speed(study: Study) -> Finding | None:
    """The mean speed of repeated manoeuvres; None where the study has none."""
    return mean_speed.finding(study) if any(covers(study, name) for name in SCENES) else None


def _summary(errors: dict[str, float]) -> str:
    within = [abs(e) for e in errors.values() if abs(e) <= GOOD]
    beyond = [abs(e) for e in errors.values() if abs(e) > GOOD]
    text = ""
    if within:
        text += (
            f" {len(within)} of {len(errors)} methods have a relative error of the total "
            f"displacement of at most {number(max(within), 2)}"
        )
    if beyond:
        text += (
            f"{';' if within else ''} the {'others' if within else 'methods'} have "
            f"{number(min(beyond), 2)} or more"
        )
    return text


SECTION = Section((total, speed), more=requests)
