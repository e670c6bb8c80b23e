"""Findings on the exact motion of a turn: the formula's next term, and a momentary stop."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.tripod_capsule.turn import EPSILONS
from plumbob.reports.analyses.capsule_turn.modes import figures, slip_speeds
from plumbob.reports.analyses.capsule_turn.turns import facts, turn
from plumbob.reports.view.content import Figure, Finding, Statement, Table, row, value
from plumbob.reports.view.notation import number
from plumbob.reports.view.palette import BLUE, RED
from plumbob.reports.view.sources import CHERNOUSKO
from plumbob.reports.view.traces import curve, figure, logarithmic, positive

CHECKED = ((0.3, -0.9068671274), (0.1, -0.9888885424), (0.03, -0.9989925407),
           (0.01, -0.9998879884))  # fmt: skip
SLOPES = slice(1, 5)  # of EPSILONS: where a fourth order is far above rounding
SLENDER = MappingProxyType(
    {"inertia": 0.002, "radius": 0.12, "angular_acceleration": 130.0, "half_time": 0.08}
)  # the check body's masses nearer to C: a support is easier to move one way than the other
SIDES = (1e-6, 1e-5, 1e-4, 1e-3)  # [s] before and after


@dataclass(frozen=True)
class FormulaErrors:
    """Exact body angle less that of a formula [rad], for each of EPSILONS."""

    stop: tuple[float, ...]  # of eq. 32 at 2 tau
    rest: tuple[float, ...]  # of eq. 32 at rest
    corrected_stop: tuple[float, ...]
    corrected_rest: tuple[float, ...]


def formula_errors() -> FormulaErrors:
    """Errors of eq. 32 and of the corrected formula at 2 tau and at rest."""
    columns = []
    for epsilon in EPSILONS:
        known = facts(epsilon)
        stop, at_rest = known["body_angle"], known["body_angle_at_rest"]
        columns.append((
            stop - known["body_angle_formula"], at_rest - known["body_angle_formula"],
            stop - known["body_angle_corrected"], at_rest - known["body_angle_corrected_at_rest"],
        ))  # fmt: skip
    return FormulaErrors(*zip(*columns, strict=True))


def slope(errors: tuple[float, ...]) -> float:
    """Slope of log error against log epsilon, from 0.1 to 0.003."""
    sizes = np.log(np.abs(errors[SLOPES]))
    return float(np.polyfit(np.log(EPSILONS[SLOPES]), sizes, 1)[0])


def logarithm(errors: tuple[float, ...]) -> float:
    """K of an error K epsilon^4 ln(1/epsilon) + B epsilon^4, from the two smallest epsilons."""
    first, second = ((e / epsilon**4, math.log(1.0 / epsilon))
                for e, epsilon in zip(errors[-2:], EPSILONS[-2:], strict=True))  # fmt: skip
    return (second[0] - first[0]) / (second[1] - first[1])


def coefficients() -> tuple[float, float]:
    """Coefficients of epsilon^2 [rad] in the body angle at 2 tau and at rest, from theory."""
    turned = turn(0.1)
    scale = turned.characteristic_time**2
    return scale * turned.correction.at_stop.heading, scale * turned.correction.at_rest.heading


def second_order(study: Study) -> Finding:
    """The check values, the errors by epsilon with their slopes, and the coefficients."""
    errors, (at_stop, at_rest) = formula_errors(), coefficients()
    last = EPSILONS[-1] ** 2
    slopes = [slope(e) for e in (errors.stop, errors.rest, errors.corrected_stop,
                                 errors.corrected_rest)]  # fmt: skip
    checks = [
        row(value(epsilon), value(check, 10), value(facts(epsilon)["body_angle"], 10),
            value(facts(epsilon)["body_angle"] - check, 2))
        for epsilon, check in CHECKED
    ]  # fmt: skip
    rows = [
        row(value(epsilon), *(value(e[k]) for e in (errors.stop, errors.corrected_stop,
                                                    errors.rest, errors.corrected_rest)))
        for k, epsilon in enumerate(EPSILONS)
    ]  # fmt: skip
    rows.append(row("slope, 0.1 to 0.003", *(value(slopes[k]) for k in (0, 2, 1, 3))))
    return Finding(
        "capsule-turn-second-order",
        "The turn formula's next term is known, and is not the same at 2τ and at rest",
        "extended",
        "The paper's formula promises too large a turn; with its next term it is accurate "
        "enough to plan with. "
        f"The body turns less than –μ₁Zτ² (eq. 32) by {number(at_stop, 8)} ε² when the slider "
        f"stops and by {number(at_rest, 8)} ε² when all is at rest; with that term added the "
        "formula's error is of fourth order.",
        (
            "ψ is the body angle; the slider turns by the angle Zτ² about C, speeding up for τ and "
            "slowing down for τ; ε = τ/T, with T the time in which friction would turn the body; "
            "μ₁ is the ratio of moments of inertia in eq. 32. The source gives the leading order "
            "alone. The next term is friction along the leading-order motion, integrated twice: "
            "its direction depends on where the slider is and not on its speed. Measured at "
            f"ε = {number(EPSILONS[-1])}: "
            f"{number(errors.stop[-1] / last, 7)} and {number(errors.rest[-1] / last, 7)}.",
            "The remainder at 2τ has slope 4. At rest it is K ε⁴ ln(1/ε), since the directions of "
            "sliding reverse within ε²τ of the slider's stop: theory gives K = –2.3733, and the "
            f"two smallest ε give {number(logarithm(errors.corrected_rest), 4)}. The derivation is "
            "in analytic/README.md.",
        ),
        (
            Table("ψ(2τ) of the exact motion [rad]",
                  ("ε", "check value", "computed", "difference"), tuple(checks),
                  "The check values are accurate to 2e-10; the computed ones to 1e-14."),
            Table("Exact body angle less the formula's [rad]",
                  ("ε", "eq. 32 at 2τ", "corrected at 2τ", "eq. 32 at rest", "corrected at rest"),
                  tuple(rows)),
        ),
        (_against_epsilon(errors),),
        ("plumbob solve capsule-turn/0.1 --json", "plumbob solve capsule-turn/0.001 --json"),
        (
            Statement(
                CHERNOUSKO,
                "(32)",
                "Δψ of a turn",
                "–μ₁Zτ² + O(ε²)",
                f"–μ₁Zτ² + {number(at_stop, 8)} ε² at 2τ, + {number(at_rest, 8)} ε² at rest",
                "extended",
            ),),
    )  # fmt: skip


def _against_epsilon(errors: FormulaErrors) -> Figure:
    """The formulas' errors at rest against epsilon."""
    drawn = (("eq. 32", errors.rest, RED), ("with the next term", errors.corrected_rest, BLUE))
    traces = [
        curve(EPSILONS, positive(e), colour=colour, marks=True, name=name)
        for name, e, colour in drawn
    ]
    return figure(
        "Error of the turn formula against ε",
        "At rest, for a turn of about 1 rad.",
        traces,
        logarithmic("ε [1]"),
        logarithmic("|error of ψ| [rad]"),
        legend=True,
    )


def motion() -> ThreePointMotion:
    """A turn of a body with little inertia, in which a support stops and leaves at once."""
    scene = find_scene("capsule-turn", SLENDER)
    single = case_of(scene).problem.motion.single
    assert isinstance(single, ThreePointMotion)
    return single


def touches(single: ThreePointMotion) -> list[tuple[float, int]]:
    """Times [s] and supports (0, 1, 2) that stop and leave while the others slide."""
    return [
        (now.time, now.support)
        for before, now in pairwise(single.events)
        if before.mode == now.mode == "slide" and now.support >= 0
    ]


def touching(study: Study) -> Finding:
    """The slip speed on either side of the stop, and what it means."""
    single, tau = motion(), SLENDER["half_time"]
    (time, support), *_ = touches(single)
    sides = np.array(SIDES)
    before, at, after = (
        slip_speeds(single, np.atleast_1d(when))[support]
        for when in (time - sides, time, time + sides)
    )
    rows = [
        row(value(s, 1), value(b), value(a), value(b / s), value(a / s))
        for s, b, a in zip(SIDES, map(float, before), map(float, after), strict=True)
    ]
    options = " ".join(f"--set {name}={amount:g}" for name, amount in SLENDER.items())
    return Finding(
        "capsule-turn-touch",
        "A support can stop and slide on at once",
        "extended",
        "An event-driven simulation needs one more case than sliding, pivoting and resting. "
        f"At {number(time / tau, 4)} τ of a turn of a slender body A{support + 1} comes to "
        f"v = 0 ({number(float(at[0]), 1)} m/s), friction cannot hold it, and it slides on in "
        "another direction without resting.",
        (
            "Friction (1) leaves three modes of motion: all supports slide, one is at rest, or all "
            "are. Near v = 0 the direction of slip converges to a ray, along which the speed falls "
            "to zero in finite time, although holding the support would need more force than "
            "friction has. It continues along "
            "another ray. That needs a support whose effective mass depends on the direction, and "
            "it is robust: every nearby start does the same. An integrator that takes such a stop "
            "for rest, or steps over it, gets this motion wrong.",
        ),
        (
            Table("Slip speed [m/s] before and after the stop",
                  ("time from it [s]", "before", "after", "before, over the time [m/s²]",
                   "after, over the time [m/s²]"), tuple(rows)),
        ),
        figures(single, tau),
        (f"plumbob solve capsule-turn {options} --json",),
        (Statement(CHERNOUSKO, "(1)", "A support slides, or is at rest where fN_i suffices",
                   "(1)", f"it can stop and slide on at once, as at {number(time / tau, 4)} τ of a "
                   "slender body's turn", "extended"),),
    )  # fmt: skip
