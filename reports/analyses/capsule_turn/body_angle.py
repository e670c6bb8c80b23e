"""Findings on the engines' body angle over epsilon: errors, their cause, and contact deflection."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from plumbob.analytic.errors.sliding_motion.plane_errors import euler_lead
from plumbob.engines.study.results import Study
from plumbob.models.tripod_capsule.turn import EPSILONS, PARTS
from plumbob.reports.analyses.capsule_turn.exact_motion import formula_errors, slope
from plumbob.reports.analyses.capsule_turn.turns import (
    JUDGED,
    METHODS,
    When,
    epsilons,
    judged_error,
    order_of,
    seen,
    turn,
)
from plumbob.reports.analyses.claims import at_most, clear
from plumbob.reports.view.content import (
    Cell,
    Claim,
    Figure,
    Finding,
    Table,
    plain_method_cell,
    row,
    value,
)
from plumbob.reports.view.notation import number
from plumbob.reports.view.palette import GREY, OF_METHODS, OLIVE, PLUM
from plumbob.reports.view.traces import Trace, curve, figure, logarithmic, positive

ASKED, FROM = 1e-4, 0.03  # [rad], for epsilon of so much and more
WHY = MappingProxyType({
    "mujoco/euler": "contact chatter",
    "mujoco/euler+coulomb": "semi-implicit Euler loses angular momentum",
})  # fmt: skip
EULER, RK4, DEFAULT = "mujoco/euler+coulomb", "mujoco/rk4+coulomb", "mujoco/euler"
HARM = 1e-3  # [rad] added to a turn
DEFLECTION = "contact deflection"  # the reason of its model-error bound
Errors = dict[tuple[float, str], tuple[float | None, float | None]]


def angle(study: Study) -> Finding | None:
    """Errors at 2 tau and at rest by epsilon and method, with orders and the accuracy asked for;
    None without an engine."""
    errors: Errors = {}
    for epsilon in epsilons(study):
        for name in METHODS:
            pair = _both(study, epsilon, name)
            if None not in pair:
                errors[epsilon, name] = pair
    if not errors:
        return None
    ordered = study.profile == "full"
    rows = []
    for (epsilon, name), (stop, final) in errors.items():
        cells = [value(stop)]
        if ordered:
            cells.append(value(order_of(study, epsilon, name, "stop")))
        cells += [value(final), value(order_of(study, epsilon, name, "rest"))]
        rows.append(
            row(
                value(epsilon),
                plain_method_cell(name),
                *cells,
                *_judged(epsilon, name, stop, final),
            )
        )
    orders = ("order",) if ordered else ()
    heads = ("ε", "method", "at 2τ [rad]", *orders, "at rest [rad]", "order",
             f"≤ {ASKED:g} rad", "reason")  # fmt: skip
    note = "Orders are fitted to the study's steps, τ/50 to τ/3200."
    if not ordered:
        note += " The full profile has every ε, and orders at 2τ too."
    return Finding(
        "capsule-turn-angle",
        "The body angle of a turn: errors of the engines and of the formulas",
        "measured",
        "For turns take RK4 with contacts that converge, or pymunk's feet; Euler steps are "
        "far less accurate. " + _summary(errors),
        (
            "The step is a fraction of the turn's half time τ, because speeds grow as 1/ε, with "
            "ε = τ/T and T the time in which friction would turn the body. For ε of 0.01 and less "
            "the corrected formula is more accurate than every engine at any step from τ/50 to "
            "τ/3200; at large ε, where friction matters most, an engine that converges is better.",
            "With RK4 and pymunk the error from the drive is of second order, and the error from "
            "friction, which ends inside a step, of first order, and smaller at smaller ε. The two "
            "have opposite signs: where they are equally large, the error passes through zero "
            "among the steps, and a fitted slope is that of neither.",
        ),
        (Table(f"Error of the body angle with steps of τ/{JUDGED}", heads, tuple(rows), note),),
        tuple(_figure(study, when, errors) for when in ("stop", "rest")),
        (
            "plumbob validate --profile full --scenes 'capsule-turn/0*' "
            "--methods mujoco/euler*,mujoco/rk4+coulomb,pymunk/feet",
            f"plumbob run capsule-turn/0.3 {RK4} --step {turn(0.3).half_time / JUDGED:.17g}",
        ),
        claims=(*_claims(errors),),
    )


def _both(study: Study, epsilon: float, name: str) -> tuple[float | None, float | None]:
    return (judged_error(study, epsilon, name, "stop"),
            judged_error(study, epsilon, name, "rest"))  # fmt: skip


def _worst(stop: float | None, final: float | None) -> float:
    return max(abs(e) for e in (stop, final) if e is not None)


def _judged(epsilon: float, name: str, stop: float | None, final: float | None) -> Sequence[Cell]:
    if epsilon < FROM:
        return (Cell("–", "", f"asked for at ε ≥ {FROM:g}"), Cell(""))
    if _worst(stop, final) <= ASKED:
        return (Cell("met", "pass"), Cell(""))
    return (Cell("not met", "fail"), Cell(WHY.get(name, ""), "reason"))


def _held(errors: Errors) -> dict[str, float | None]:
    """The largest error [rad] of each method at the ε that it is asked for."""
    return {
        name: max((_worst(*pair) for (e, n), pair in errors.items() if n == name and e >= FROM),
                  default=None)
        for name in METHODS
    }  # fmt: skip


def _claims(errors: Errors) -> tuple[Claim, ...]:
    """That Euler steps are far less accurate than RK4 and pymunk's feet."""
    held = _held(errors)
    euler = held.get(EULER)
    pairs = [(name, held[name]) for name in (RK4, "pymunk/feet") if name in held]
    return tuple(
        clear(f"the error of {EULER}, and of {name},", euler, error, "rad")
        for name, error in pairs
        if euler is not None and error is not None
    )


def _summary(errors: Errors) -> str:
    held = _held(errors)
    good = [f"{name} ({number(w, 2)})" for name, w in held.items() if w is not None and w <= ASKED]
    bad = [f"{name} ({number(w, 2)})" for name, w in held.items() if w is not None and w > ASKED]
    parts = []
    if good:
        parts.append(f"at most {ASKED:g} rad with {' and '.join(good)}")
    if bad:
        parts.append(f"larger with {' and '.join(bad)}")
    return (
        f"With steps of τ/{JUDGED} and ε ≥ {FROM:g} the error of the body angle is "
        f"{', and '.join(parts)}."
    )


def _figure(study: Study, when: When, errors: Errors) -> Figure:
    """Error against epsilon of the formulas, of the engines at tau/JUDGED, and of Euler's step."""
    formulas, at_stop = formula_errors(), when == "stop"
    lines = (
        (formulas.stop, formulas.corrected_stop)
        if at_stop
        else (formulas.rest, formulas.corrected_rest)
    )
    traces: list[Trace] = [
        curve(EPSILONS, positive(line), colour=colour, width=2.4,
              name=f"{label}, slope {number(slope(line))}",
              hint=f"{label}, ε %{{x:.3g}}: %{{y:.3g}} rad")
        for line, colour, label in zip(
            lines, (PLUM, OLIVE), ("eq. 32", "corrected"), strict=True
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
        here = [(e, pair[0 if at_stop else 1]) for (e, n), pair in errors.items() if n == name]
        known = [(e, error) for e, error in here if error is not None]
        if known:
            traces.append(
                curve([e for e, _ in known], positive([error for _, error in known]),
                      colour=OF_METHODS[name], marks=True, width=1.0, name=name,
                      hint=f"{name}, ε %{{x:.3g}}: %{{y:.3g}} rad")
            )  # fmt: skip
    return figure(
        f"Error of the body angle {'at 2τ' if at_stop else 'at rest'} against ε",
        f"Formulas against the exact motion; engines at τ/{JUDGED}.",
        traces, logarithmic("ε = τ/T"), logarithmic("|error of ψ| [rad]"),
        legend=True, height=460,
    )  # fmt: skip


def _step_errors(study: Study, when: When, parts: int) -> list[tuple[float, float]]:
    """The predicted error of Euler's step of tau/`parts`: at 2 tau by its formula, the same for
    every epsilon; at rest where the study has it."""
    if when == "stop":
        return [(e, euler_lead(turn(e)) * turn(e).half_time / parts) for e in EPSILONS]
    pairs = []
    for epsilon in epsilons(study):
        here = seen(study, epsilon, EULER, parts)
        predicted = here.errors["body_angle"].predicted if here else None
        if predicted is not None:
            pairs.append((epsilon, predicted.end))
    return pairs


def leak(study: Study) -> Finding | None:
    """Error at 2 tau over mu_1^2 Z^3 tau^5 h/2 by method and epsilon; None without MuJoCo."""
    ratios: dict[str, list[float]] = {}
    for name in METHODS[1:]:
        for epsilon in epsilons(study):
            if (error := judged_error(study, epsilon, name, "stop")) is None:
                continue
            step = turn(epsilon).half_time / JUDGED
            ratios.setdefault(name, []).append(error / (euler_lead(turn(epsilon)) * step))
    ratios = {name: sizes for name, sizes in ratios.items() if len(sizes) == len(epsilons(study))}
    if EULER not in ratios:
        return None
    manoeuvre = turn(epsilons(study)[0])
    lead = euler_lead(manoeuvre) * manoeuvre.half_time / JUDGED
    rows = [
        row(plain_method_cell(name), *(value(r) for r in sizes)) for name, sizes in ratios.items()
    ]
    heads = ("method", *(f"ε = {number(e)}" for e in epsilons(study)))
    return Finding(
        "capsule-turn-leak",
        "Semi-implicit Euler loses angular momentum while the slider moves along its circle",
        "explained",
        "Euler steps lose angular momentum whenever a mass runs round a circle: take RK4. "
        f"The body turns too little by ½μ₁²Z³τ⁵h, with h the step: {number(lead)} rad with steps "
        f"of τ/{JUDGED} for a turn of one radian, whatever ε. The error is proportional to the "
        "step.",
        (
            "A step combines the slider's position at its start with its velocity at its end, so "
            "the angular momentum about the common centre of mass falls by μMh v²ω each second (v, "
            "ω: velocities of the slider and the body), as with a damper on the body. Friction "
            "plays no part.",
            "The momentum that is missing at 2τ turns the body after the slider has stopped, so "
            "the error after 5τ, where the exact motion has come to rest, is larger: at small ε "
            "friction has no time to stop that within the scene, and the error is four times that "
            "at 2τ.",
            "RK4 follows the slider along its circle, and pymunk's slider is placed where it has "
            "to be at the end of every step. Their errors at small ε are of second order; Euler "
            f"would need steps of about τ/{round(1e4 * lead * JUDGED, -3):.0f} for 1e-4 rad.",
        ),
        (
            Table(f"Error at 2τ over ½μ₁²Z³τ⁵h, steps of τ/{JUDGED}", heads, tuple(rows),
                  "At large ε friction turns the body too: the ratio's difference from 1."),
        ),
        (),
        (f"plumbob run capsule-turn/0.03-stop {EULER} --step "
         f"{turn(0.03).half_time / JUDGED:.17g}",),
    )  # fmt: skip


def deflection(study: Study) -> Finding | None:
    """Vertical displacement, and the error at rest beyond the step's, on default and on convergent
    contacts; None where the study has no such runs."""
    rows, vertical, beyond = [], dict[str, list[float]](), dict[str, list[float]]()
    for epsilon in epsilons(study):
        for name in (EULER, DEFAULT):
            run = seen(study, epsilon, name, JUDGED)
            error = None if run is None else run.errors["body_angle"]
            if run is None or error is None or error.predicted is None:
                continue
            left = error.end - error.predicted.end
            vertical.setdefault(name, []).append(run.channels["vertical_displacement"])
            beyond.setdefault(name, []).append(abs(left))
            rows.append(
                row(value(epsilon), plain_method_cell(name), value(driving_force(epsilon), 2),
                    value(run.channels["vertical_displacement"], 2), value(left, 2),
                    value(error.model.get(DEFLECTION), 2))
            )  # fmt: skip
    if set(vertical) != {EULER, DEFAULT}:
        return None
    heads = ("ε", "method", "largest force on the slider [N]", "vertical displacement, range [m]",
             "error at rest beyond the step's [rad]",
             "its bound from contact deflection [rad]")  # fmt: skip
    return Finding(
        "capsule-turn-deflection",
        "Contact deflection does no harm at small ε where stiffness goes with the step",
        "measured",
        "Soft contacts do no harm to a quick turn if their stiffness goes with the step; "
        "default contacts do. "
        "The slider's horizontal force acts above the deflected contacts and tips the body. "
        "Contacts of frequency 0.4/dt deflect by at most "
        f"{number(max(vertical[EULER]), 2)} m, less at smaller ε, and add at most "
        f"{number(max(beyond[EULER]), 2)} rad to the turn; on default contacts the body moves "
        f"vertically by up to {number(1e3 * max(vertical[DEFAULT]), 2)} mm, and they add up to "
        f"{number(max(beyond[DEFAULT]), 2)} rad.",
        (
            "Normal forces are those of the weight at every ε. The slider's centripetal force "
            "grows as ε⁻², but the step is a fraction of τ, so the stiffness (0.4/dt)² grows at "
            "the same rate: the moment of the force stays the same, and acts for a time "
            "proportional to ε. Default contacts keep their time constant of 20 ms, their "
            "deflection does not shrink, and the force lifts the body off the plane.",
        ),
        (Table(f"Steps of τ/{JUDGED}, at rest", heads, tuple(rows),
               "No bound is claimed for default contacts."),),
        (),
        ("plumbob validate --profile full --scenes capsule-turn/0.3,capsule-turn/0.001 "
         f"--methods {DEFAULT},{EULER}",),
        claims=(
            at_most("what contacts that go with the step add", max(beyond[EULER]), HARM, "rad"),
            clear("vertical displacements, on default contacts and on those of the step",
                  max(vertical[DEFAULT]), 0.1 * max(vertical[EULER]), "m"),
        ),
    )  # fmt: skip


def driving_force(epsilon: float) -> float:
    """Largest force that moves the slider in the body [N], to leading order: m times |w|."""
    manoeuvre = turn(epsilon)
    _, _, acceleration = manoeuvre.path.kinematics(np.array([manoeuvre.half_time * (1.0 - 1e-9)]))
    return float(manoeuvre.capsule.slider_mass * np.hypot(*acceleration[0]))
