"""The page's section on trains of manoeuvres: errors that add up, and what a manoeuvre costs."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.findings.capsule.cells import method as method_cell
from plumbob.reports.findings.capsule.cells import value
from plumbob.reports.findings.capsule.runs import covers, measured, names, problem
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Figure, Finding, Section, Table, row
from plumbob.reports.view.notation import number, short

SCENES = ("capsule-train/thousand", "capsule-train/ten")  # the longer one, where it was run
STEP = 1e-3  # [s]
GOOD = 1e-3  # of the whole


def findings(study: Study) -> Sequence[Finding]:
    """Total displacement of each method against count times eq. 22, and cost per manoeuvre."""
    scene = next((name for name in SCENES if covers(study, name)), None)
    if scene is None:
        return ()
    train = problem(scene).motion
    rows, errors = [], {}
    for name in names(study):
        if (found := measured(study, scene, name, STEP)) is None:
            continue
        error = found.errors["displacement"]
        errors[name] = error.end / train.displacement
        told = None if error.predicted is None else error.predicted.end / train.displacement
        each = study.costs.get((scene, name))
        cost = None if each is None else each.ns_per_step * 1e-9 * found.steps / train.count
        rows.append(
            row(method_cell(name), value(train.displacement + error.end, 6), value(errors[name]),
                value(told), Cell("–" if cost is None else notation.seconds(cost), "number"))
        )  # fmt: skip
    if not rows:
        return ()
    within = [abs(e) for e in errors.values() if abs(e) <= GOOD]
    beyond = [abs(e) for e in errors.values() if abs(e) > GOOD]
    said = f"After {train.count} manoeuvres of {number(1e3 * train.manoeuvre.displacement)} mm"
    if within:
        said += (
            f" {len(within)} of {len(errors)} methods are within {number(max(within), 2)} of the "
            "exact way"
        )
    if beyond:
        said += f"{';' if within else ''} the others are off by {number(min(beyond), 2)} or more"
    heads = ("method", "total displacement [m]", "relative error", "predicted", "per manoeuvre")
    return (
        Finding(
            "capsule-train-total",
            "Manoeuvres in a row: the error of one, so many times",
            "confirmed",
            f"{said}.",
            (
                "Each manoeuvre is followed by a slow return of the slider, at "
                f"{number(train.fraction)} of what friction holds, and by a pause that puts the "
                f"next start on the grid of steps: {number(train.period)} s in all. What theory "
                "says of one manoeuvre then adds up, and nothing else does.",
            ),
            (Table(f"{scene.partition('/')[2]}, step {short(STEP)} s, exact "
                   f"{number(train.displacement, 6)} m", heads, tuple(rows),
                   "Cost: wall time of the stepping alone, of 320 steps."),),
            (),
            ("plumbob validate --profile full --scenes capsule-train/thousand",
             "plumbob run capsule-train/ten mujoco/euler+coulomb --step 1e-3"),
        ),
    )  # fmt: skip


def _figures(study: Study) -> Sequence[tuple[str, Sequence[Figure]]]:
    return ()


def _hard(study: Study, scene: Scene) -> Sequence[Figure | Table]:
    return ()


SECTION = Section(findings, _figures, _hard)
