"""The finding on the engines' body angle over epsilon, beside what the formulas err by."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

from plumbob.analytic.errors.plane_errors import euler_lead
from plumbob.engines.study.study import Study
from plumbob.models.tripod_capsule.turn import EPSILONS, PARTS
from plumbob.reports.findings.capsule.cells import named, value
from plumbob.reports.findings.capsule.runs import COLOURS, GREY
from plumbob.reports.findings.capsule_turn.formulas import formula_errors, slope
from plumbob.reports.findings.capsule_turn.runs import (
    JUDGED,
    METHODS,
    When,
    angle_off,
    epsilons,
    order_of,
    seen,
    turn,
)
from plumbob.reports.view.content import Cell, Figure, Finding, Table, row
from plumbob.reports.view.notation import number
from plumbob.reports.view.traces import Trace, curve, figure, logarithmic, positive

BAR, FROM = 1e-4, 0.03  # [rad], for epsilon of so much and more
WHY = MappingProxyType({
    "mujoco/euler": "the body hops on its contacts",
    "mujoco/euler+coulomb": "semi-implicit Euler loses angular momentum",
})  # fmt: skip
FORMULA, CORRECTED = "#b05a8c", "#6b8e23"
EULER, RK4 = "mujoco/euler+coulomb", "mujoco/rk4+coulomb"
Errors = dict[tuple[float, str], tuple[float | None, float | None]]


def finding(study: Study) -> Finding | None:
    """Errors at 2 tau and at rest by epsilon and method, with orders and the bar; None without an
    engine."""
    errors: Errors = {}
    for epsilon in epsilons(study):
        for name in METHODS:
            pair = _both(study, epsilon, name, JUDGED)
            if None not in pair:
                errors[epsilon, name] = pair
    if not errors:
        return None
    ordered = study.profile == "full"
    rows = []
    for (epsilon, name), (stop, rest) in errors.items():
        cells = [value(stop)]
        if ordered:
            cells.append(value(order_of(study, epsilon, name, "stop")))
        cells += [value(rest), value(order_of(study, epsilon, name, "rest"))]
        rows.append(row(value(epsilon), named(name), *cells, *_judged(epsilon, name, stop, rest)))
    orders = ("order",) if ordered else ()
    heads = ("ε", "method", "at 2τ [rad]", *orders, "at rest [rad]", "order",
             f"≤ {BAR:g} rad", "why not")  # fmt: skip
    note = "Orders are fitted to the study's steps, τ/50 to τ/3200."
    if not ordered:
        note += " The full profile has every ε, and orders at 2τ as well."
    return Finding(
        "capsule-turn-angle",
        "How far each engine turns the body, and what the formulas miss",
        "measured",
        _summary(errors),
        (
            "The step is tied to the manoeuvre, for the speeds grow as 1/ε. For ε of 0.01 and less "
            "the corrected formula beats every engine at any step from τ/50 to τ/3200; at large ε, "
            "where friction matters most, an engine that converges is the better.",
            "With RK4 and pymunk the drive's part of the error is of second order and friction's, "
            "which ends within a step, of first, and less the smaller ε. The two have opposite "
            "signs: where they are as large, the error passes through zero among the steps, and "
            "the slope of a fit is neither's.",
        ),
        (Table(f"Error of the body angle with steps of τ/{JUDGED}", heads, tuple(rows), note),),
        tuple(_figure(study, when, errors) for when in ("stop", "rest")),
        (
            "plumbob validate --profile full --scenes 'capsule-turn/0*' "
            "--methods mujoco/euler*,mujoco/rk4+coulomb,pymunk/feet",
            f"plumbob run capsule-turn/0.3 {RK4} --step {turn(0.3).half_time / JUDGED:.17g}",
        ),
    )


def _both(study: Study, epsilon: float, name: str, parts: int) -> tuple[float | None, float | None]:
    return (angle_off(study, epsilon, name, parts, "stop", own=True),
            angle_off(study, epsilon, name, parts, "rest", own=True))  # fmt: skip


def _worst(stop: float | None, rest: float | None) -> float:
    return max(abs(e) for e in (stop, rest) if e is not None)


def _judged(epsilon: float, name: str, stop: float | None, rest: float | None) -> Sequence[Cell]:
    if epsilon < FROM:
        return (Cell("–", "", f"asked for ε ≥ {FROM:g}"), Cell(""))
    if _worst(stop, rest) <= BAR:
        return (Cell("met", "pass"), Cell(""))
    return (Cell("not met", "fail"), Cell(WHY.get(name, ""), "reason"))


def _summary(errors: Errors) -> str:
    held = {
        name: max((_worst(*pair) for (e, n), pair in errors.items() if n == name and e >= FROM),
                  default=None)
        for name in METHODS
    }  # fmt: skip
    good = [f"{name} ({number(w, 2)})" for name, w in held.items() if w is not None and w <= BAR]
    bad = [f"{name} ({number(w, 2)})" for name, w in held.items() if w is not None and w > BAR]
    parts = []
    if good:
        parts.append(f"{' and '.join(good)} keep the body angle to {BAR:g} rad")
    if bad:
        parts.append(f"{' and '.join(bad)} {'do not' if len(bad) > 1 else 'does not'}")
    return f"With steps of τ/{JUDGED} and ε ≥ {FROM:g} {', '.join(parts)}."


def _figure(study: Study, when: When, errors: Errors) -> Figure:
    """Error against epsilon of the formulas, of the engines at tau/JUDGED, and of Euler's step."""
    told, found = formula_errors(), when == "stop"
    lines = (told.stop, told.corrected_stop) if found else (told.rest, told.corrected_rest)
    traces: list[Trace] = [
        curve(EPSILONS, positive(line), colour=colour, width=2.4,
              name=f"{label}, slope {number(slope(line))}",
              hint=f"{label}, ε %{{x:.3g}}: %{{y:.3g}} rad")
        for line, colour, label in zip(
            lines, (FORMULA, CORRECTED), ("eq. 32", "corrected"), strict=True
        )
    ]  # fmt: skip
    for parts, dash in ((PARTS[0], "dot"), (JUDGED, "dash"), (PARTS[-1], "dashdot")):
        steps = _step_errors(study, when, parts)
        if steps:
            traces.append(
                curve([e for e, _ in steps], positive([s for _, s in steps]), colour=GREY,
                      dash=dash, name=f"Euler's step τ/{parts}, predicted")
            )  # fmt: skip
    for name in METHODS:
        here = [(e, pair[0 if found else 1]) for (e, n), pair in errors.items() if n == name]
        known = [(e, off) for e, off in here if off is not None]
        if known:
            traces.append(
                curve([e for e, _ in known], positive([off for _, off in known]),
                      colour=COLOURS[name], marks=True, width=1.0, name=name,
                      hint=f"{name}, ε %{{x:.3g}}: %{{y:.3g}} rad")
            )  # fmt: skip
    return figure(
        f"Error of the body angle {'at 2τ' if found else 'at rest'} against ε",
        f"Formulas against the exact motion; engines at τ/{JUDGED}.",
        traces, logarithmic("ε = τ/T"), logarithmic("|error of ψ| [rad]"),
        legend=True, height=460,
    )  # fmt: skip


def _step_errors(study: Study, when: When, parts: int) -> list[tuple[float, float]]:
    """What Euler's step of tau/`parts` is predicted to do: at 2 tau by its formula, the same for
    every epsilon; at rest as far as the study has it."""
    if when == "stop":
        return [(e, euler_lead(turn(e)) * turn(e).half_time / parts) for e in EPSILONS]
    found = []
    for epsilon in epsilons(study):
        here = seen(study, epsilon, EULER, parts)
        told = here.errors["body_angle"].predicted if here else None
        if told is not None:
            found.append((epsilon, told.end))
    return found
