"""The finding on the final displacement: what each method errs by, and what theory says of it."""

from __future__ import annotations

from plumbob.engines.study.results import Study
from plumbob.reports.findings.capsule.cells import method as method_cell
from plumbob.reports.findings.capsule.cells import value
from plumbob.reports.findings.capsule.runs import LINE, covers, measured, names, problem
from plumbob.reports.findings.capsule.surplus import (
    contact_of,
    creep,
    sawtooth,
    sinking,
)
from plumbob.reports.view.content import Cell, Finding, Table, row
from plumbob.reports.view.notation import number, short

STEPS = (1e-3, 1e-4, 1e-5)
TURNED = "capsule-line/heading-030"
FULL, REDUCED = "mujoco/euler+coulomb", "mujoco/euler+reduced"


def finding(study: Study) -> Finding | None:
    """Relative errors by method and step, and the full model's surplus in parts; None where the
    study has not the scene."""
    if not covers(study, LINE):
        return None
    exact = problem(LINE).motion.displacement
    rows = [
        row("theory: ½φ(1–φ)(μw₂+fg)dt² / |Δx|", *(value(sawtooth(LINE, h) / exact) for h in STEPS),
            value(sawtooth(LINE, 1e-4) / exact))
    ]  # fmt: skip
    worst = {}
    for name in names(study):
        here = [_relative(study, LINE, name, step) for step in STEPS]
        if any(error is not None for error in here):
            turned = _relative(study, TURNED, name, 1e-4)
            rows.append(row(method_cell(name), *map(value, here), value(turned)))
            worst[name] = here[1]
    good = [abs(e) for n, e in worst.items() if e is not None and _converges(n)]
    bad = [abs(e) for n, e in worst.items() if e is not None and not _converges(n)]
    summary = "Friction that converges leaves the integrator's own error, a sawtooth in the step"
    if good and bad:
        summary += (
            f": at 1e-4 s at most {number(max(good), 2)} of Δx. What does not converge is off by "
            f"{number(min(bad), 2)} to {number(max(bad), 2)} at every step"
        )
    heads = ("method", *(f"{short(h)} s" for h in STEPS), "heading 30°, 1e-4 s")
    tables = (
        Table(
            "Relative error of the final displacement: above 0, it went too far", heads, tuple(rows)
        ),
    )
    return Finding(
        "capsule-displacement",
        "What each method errs by in Δx",
        "measured",
        f"{summary}.",
        (
            "The velocity of a semi-implicit Euler scheme is exact at grid times while the body "
            "slides, and the places are its trapezoid sums: only the bend at t*, a fraction φ into "
            "its step, is missed. RK4 takes the last step of friction in a geometric series and "
            "goes ½(μw₂+fg)dt² too far.",
            "What the full model adds to that is explained: its contacts are springs, and the "
            "common centre of mass sinks on them as the loads become uneven, during which friction "
            "is smaller; and a body that is held creeps. The reduced model only creeps.",
        ),
        (*tables, *_surplus(study)),
        (),
        (
            f"plumbob validate --profile full --scenes {LINE},{TURNED} --methods mujoco,pymunk",
            f"plumbob run {LINE} {FULL} --step 1e-4",
        ),
    )


def _converges(name: str) -> bool:
    """Whether theory covers a method's friction."""
    return name.endswith(("coulomb", "coulomb+noslip", "reduced", "feet", "side"))


def _relative(study: Study, scene: str, method: str, step: float) -> float | None:
    found = measured(study, scene, method, step)
    if found is None:
        return None
    return found.errors["displacement"].end / float(problem(scene).motion.displacement)


def _surplus(study: Study) -> tuple[Table, ...]:
    """The errors of the two models beyond the sawtooth, and what explains them [m]."""
    rows = []
    for name in (FULL, REDUCED):
        for step in STEPS:
            if (found := measured(study, LINE, name, step)) is None:
                continue
            beyond = found.errors["displacement"].end - sawtooth(LINE, step)
            contact = contact_of(LINE, name, step)
            sunk, crept = sinking(LINE, contact), creep(LINE, contact)
            cells = (beyond, sunk, crept, beyond - sunk - crept)
            rows.append(row(method_cell(name), Cell(short(step), "number"), *map(value, cells)))
    if not rows:
        return ()
    heads = ("method", "step [s]", "beyond the sawtooth [m]", "sinking: –f (z₀ – z) [m]",
             "creep while held [m]", "left [m]")  # fmt: skip
    note = (
        "Sinking: z = –c ΣNᵢ²/W with c the compliance of a contact. Creep of the reduced model: "
        "(1–d)/d μw₂ dt (t₂–t*) with d its impedance; of the full one the same with its friction's "
        "regularisation over three contacts. Left: the contacts' lag, and the slider's yielding by "
        "m/A of its way in space, A its armature: 3e-13 m."
    )
    return (Table("The models' own share", heads, tuple(rows), note),)
