"""The page's section on the capsule held by friction on a tilted plane: how far it drifts."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.results import Study
from plumbob.models.registry import scenes as find_scenes
from plumbob.models.scene import Scene
from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.claims import clear
from plumbob.reports.analyses.measurements import measured, names
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

STEPS = (1e-3, 2e-3)  # [s]: the first that a study has is shown; the quick profile has the second
HARDEST = "capsule-hold/0.999"
SLIDES = 0.1  # [m]: more than any drift of stiction, in ten seconds


def finding(study: Study) -> Finding | None:
    """Drift of each method in metres and metres a second, at each fraction that was run; None where
    none was."""
    tilted = [s for s in find_scenes("capsule-hold") if s.name in {o.name for o in study.scenes}]
    tilted = [s for s in tilted if "length" not in s.parameters]
    if not tilted:
        return None
    rows, last, step = [], {}, _step(study, tilted[-1].name)
    for name in names(study):
        drifts = [_drift(study, scene.name, name, step) for scene in tilted]
        if all(drift is None for drift in drifts):
            continue
        last[name] = drifts[-1]
        cells = [cell for drift, scene in zip(drifts, tilted, strict=True)
                 for cell in _pair(drift, scene.duration)]  # fmt: skip
        rows.append(row(method_cell(name), *cells))
    heads = ("method", *(
        f"{scene.name.partition('/')[2]} of the threshold: {what}"
        for scene in tilted for what in ("displacement in 10 s [m]", "drift [m/s]")
    ))  # fmt: skip
    table = Table(f"Drift of regularised stiction at a step of {short(step)} s", heads, tuple(rows))
    return _finding(table, tilted, last, step)


def _step(study: Study, scene: str) -> float:
    """The first of STEPS at which any method was measured on a scene."""
    ran = (s for s in STEPS if any(measured(study, scene, name, s) for name in names(study)))
    return next(ran, STEPS[0])


def _finding(
    table: Table, tilted: Sequence[Scene], last: dict[str, float | None], step: float
) -> Finding:
    known = {name: drift for name, drift in last.items() if drift is not None}
    convergent = [d for n, d in known.items() if n.endswith(("coulomb", "feet", "side"))]
    noslip = [d for n, d in known.items() if n.endswith("coulomb+noslip")]
    sliding = [n for n, d in known.items() if d > SLIDES]
    text = f"In 10 s at {tilted[-1].name.partition('/')[2]} of the largest tilt that friction holds"
    if not known:
        name = tilted[-1].name.partition("/")[2]
        text = f"No method ran at {name} of the largest tilt with a step of {short(step)} s"
    if convergent:
        text += f" a body on convergent contacts drifts by at most {number(max(convergent), 2)} m"
    if noslip:
        text += f", with noslip by {number(max(noslip), 2)} m"
    if sliding:
        text += f"; with {', '.join(sliding)} the body slides away"
    return Finding(
        "capsule-stiction-drift",
        "Stiction drifts, and the contact model decides how fast",
        "measured",
        "A robot that should stand still on a slope drifts, and the contact settings decide "
        "how fast. "
        f"{text}.",
        (
            "Gravity is tilted by a fraction of the angle at which friction would give way; the "
            "slider is fixed. MuJoCo regularises friction at rest as a damper: drift speed over "
            "force is its compliance. A larger impratio makes it smaller, and so does a smaller "
            "step where the contact depends on the step; only noslip makes it zero. A pyramidal "
            "cone has 0.71 of the friction between its edges, so at 40° the body slides at 0.9 of "
            "the threshold. pymunk's joints and contacts hold to round-off, except three bare "
            "pivots, which do not distribute the load and give way.",
        ),
        (table,),
        (),
        ("plumbob validate --profile full --scenes 'capsule-hold/0*' --methods mujoco,pymunk",
         f"plumbob run {HARDEST} mujoco/euler+coulomb --step 1e-3"),
        (Statement(CHERNOUSKO, "(21)", "Below |w| = fg/μ friction holds the body at rest",
                   "at rest", "at rest, exactly, up to the limit"
                   + (f"; in engines, steps of {short(step)} s: {text[0].lower()}{text[1:]}"
                      if known else ""),
                   "holds"),),
        claims=(
            (clear("the fastest drift and the slowest", max(known.values()), min(known.values()),
                   "m"),)
            if len(known) > 1
            else ()
        ),
    )  # fmt: skip


def _drift(study: Study, scene: str, method: str, step: float) -> float | None:
    run = measured(study, scene, method, step)
    return None if run is None else abs(run.errors["displacement"].end)


def _pair(drift: float | None, duration: float) -> tuple[Cell, Cell]:
    """The displacement and the mean speed; a body that slides away has no drift speed."""
    if drift is not None and drift > SLIDES:
        return Cell("slides", "number", f"by {number(drift)} m"), Cell("", "number")
    return value(drift, 2), value(None if drift is None else drift / duration, 2)


SECTION = Section((finding,))
