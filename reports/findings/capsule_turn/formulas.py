"""The finding on the turn's formula: what eq. 32 errs by, and its second order."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plumbob.models.tripod_capsule.turn import EPSILONS
from plumbob.reports.findings.capsule.cells import value
from plumbob.reports.findings.capsule_turn.runs import facts, turn
from plumbob.reports.view.content import Finding, Table, row
from plumbob.reports.view.notation import number

CHECKED = ((0.3, -0.9068671274), (0.1, -0.9888885424), (0.03, -0.9989925407),
           (0.01, -0.9998879884))  # fmt: skip
SLOPES = slice(1, 5)  # of EPSILONS: where a fourth order is far above rounding


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
        said = facts(epsilon)
        stop, rest = said["body_angle"], said["body_angle_at_rest"]
        columns.append((
            stop - said["body_angle_formula"], rest - said["body_angle_formula"],
            stop - said["body_angle_corrected"], rest - said["body_angle_corrected_at_rest"],
        ))  # fmt: skip
    return FormulaErrors(*zip(*columns, strict=True))


def slope(errors: tuple[float, ...]) -> float:
    """Slope of log error against log epsilon, from 0.1 to 0.003."""
    sizes = np.log(np.abs(errors[SLOPES]))
    return float(np.polyfit(np.log(EPSILONS[SLOPES]), sizes, 1)[0])


def logarithm(errors: tuple[float, ...]) -> float:
    """K of an error K epsilon^4 ln(1/epsilon) + B epsilon^4, from the two smallest epsilons."""
    one, two = ((e / epsilon**4, math.log(1.0 / epsilon))
                for e, epsilon in zip(errors[-2:], EPSILONS[-2:], strict=True))  # fmt: skip
    return (two[0] - one[0]) / (two[1] - one[1])


def coefficients() -> tuple[float, float]:
    """Coefficients of epsilon^2 [rad] in the body angle at 2 tau and at rest, from theory."""
    one = turn(0.1)
    scale = one.characteristic_time**2
    return scale * one.correction.at_stop.heading, scale * one.correction.at_rest.heading


def finding() -> Finding:
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
        f"The body turns less than –μ₁Zτ² (eq. 32) by {number(at_stop, 8)} ε² when the slider "
        f"stops and by {number(at_rest, 8)} ε² when all is at rest; with that term added the "
        "formula errs by the fourth order.",
        (
            "The source gives the leading order alone. Friction along the leading-order motion, "
            "integrated twice, is the next: its direction depends on where the slider is and not "
            f"on how fast it goes. Seen at ε = {number(EPSILONS[-1])}: "
            f"{number(errors.stop[-1] / last, 7)} and {number(errors.rest[-1] / last, 7)}.",
            "What is left at 2τ has slope 4. At rest it is K ε⁴ ln(1/ε), for the directions of "
            "sliding turn round within ε²τ of the slider's stop: theory gives K = –2.3733, and the "
            f"two smallest ε show {number(logarithm(errors.corrected_rest), 4)}. The derivation is "
            "in analytic/README.md.",
        ),
        (
            Table("ψ(2τ) of the exact motion [rad]",
                  ("ε", "check value", "computed", "difference"), tuple(checks),
                  "The check values are good to 2e-10; the computed ones to 1e-14."),
            Table("Exact body angle less the formula's [rad]",
                  ("ε", "eq. 32 at 2τ", "corrected at 2τ", "eq. 32 at rest", "corrected at rest"),
                  tuple(rows)),
        ),
        (),
        ("plumbob solve capsule-turn/0.1 --json", "plumbob solve capsule-turn/0.001 --json"),
    )  # fmt: skip
