"""The velocities that the body has left when the slider stops, which the source takes for zero."""

from __future__ import annotations

from plumbob.engines.study.results import Study
from plumbob.models.tripod_capsule.turn import EPSILONS
from plumbob.reports.analyses.capsule_turn.turns import (
    JUDGED,
    METHODS,
    epsilons,
    facts,
    judged_error,
    turn,
)
from plumbob.reports.view.content import Figure, Finding, Statement, Table, method_cell, row, value
from plumbob.reports.view.notation import number
from plumbob.reports.view.palette import GREY, OLIVE
from plumbob.reports.view.sources import CHERNOUSKO
from plumbob.reports.view.traces import Trace, curve, figure, logarithmic

SHOWN = 0.1  # epsilon of the summary


def finding(study: Study) -> Finding:
    """omega and |v| at 2 tau over epsilon, exact, by the formula, and as engines have omega."""
    about = facts(SHOWN)
    omega, speed = about["angular_velocity_at_stop"], about["speed_at_stop"]
    rows = []
    for epsilon in EPSILONS:
        fact = facts(epsilon)
        exact, formula = fact["angular_velocity_at_stop"], fact["angular_velocity_at_stop_formula"]
        slow, guess = fact["speed_at_stop"], fact["speed_at_stop_formula"]
        rows.append(
            row(value(epsilon), value(exact, 5), value(formula, 5), value(exact / formula - 1.0),
                value(slow, 5), value(guess, 5), value(fact["rest_time"] - fact["stop_time"]))
        )  # fmt: skip
    engines = [
        row(value(epsilon), method_cell(method), value(rate, 5),
            value(rate - facts(epsilon)["angular_velocity_at_stop"]))
        for epsilon in epsilons(study)
        for method in METHODS
        if (rate := _measured(study, epsilon, method)) is not None
    ]  # fmt: skip
    coefficient = turn(SHOWN).correction.left_at_stop.heading
    tables = [
        Table("When the slider stops, at 2τ",
              ("ε", "ω [rad/s]", "by the formula", "relative difference", "|v| [m/s]",
               "by the formula", "until all rests [s]"), tuple(rows),
              "v is the velocity of C."),
    ]  # fmt: skip
    if engines:
        heads = ("ε", "method", "ω(2τ) [rad/s]", "less the exact one")
        tables.append(Table(f"In engines, steps of τ/{JUDGED}", heads, tuple(engines)))
    return Finding(
        "capsule-turn-left-over",
        "After 2τ the rotation does not stop: it is left with a velocity in proportion to ε",
        "corrected",
        "Wait before the next manoeuvre: the body still turns when the slider has stopped. "
        f"At ε = {number(SHOWN)} the body still turns at {number(omega)} rad/s when the slider "
        f"stops, and its centre moves at {number(1e3 * speed)} mm/s; friction ends both later.",
        (
            "The source ends the manoeuvre at 2τ with “rotation stops”. That is the leading order: "
            "without friction the slider's stop is the body's. Friction acts on the body for all "
            "of 2τ, mostly against its turn, and what it has taken by then is left with the other "
            f"sign: ω(2τ) = {number(coefficient, 6)} rad/s² · τ for the check body, to which "
            "ε² ln(1/ε) of it is added. Derivation: analytic/README.md, eq. 5.",
            "So a body that has been turned must wait for its residual motion to end before the "
            "next manoeuvre: the last column.",
        ),
        tuple(tables),
        (_figure(),),
        ("plumbob solve capsule-turn/0.1", "plumbob solve capsule-turn/0.01"),
        (
            Statement(
                CHERNOUSKO,
                "(31), (32)",
                "After 2τ rotation stops",
                "ω(2τ) = 0",
                f"{number(omega)} rad/s and {number(1e3 * speed)} mm/s at ε = {number(SHOWN)}",
                "corrected",
                "To leading order only.",
            ),
        ),
    )


def _measured(study: Study, epsilon: float, method: str) -> float | None:
    """omega at 2 tau [rad/s] of a run at the step judged."""
    error = judged_error(study, epsilon, method, "stop", "heading_rate")
    return None if error is None else facts(epsilon)["angular_velocity_at_stop"] + error


def _figure() -> Figure:
    traces: list[Trace] = []
    for key, unit, colour in (
        ("angular_velocity_at_stop", "ω [rad/s]", OLIVE), ("speed_at_stop", "|v| [m/s]", GREY)
    ):  # fmt: skip
        exact = [abs(facts(epsilon)[key]) for epsilon in EPSILONS]
        formula = [abs(facts(epsilon)[f"{key}_formula"]) for epsilon in EPSILONS]
        traces.append(curve(EPSILONS, exact, colour=colour, marks=True, name=unit))
        traces.append(curve(EPSILONS, formula, colour=colour, dash="dash", name=f"{unit}, formula"))
    return figure(
        "What is left at 2τ",
        "Dashed: the next order beyond the source, in proportion to ε.",
        traces,
        logarithmic("ε"),
        logarithmic("ω [rad/s], |v| [m/s]"),
        legend=True,
        height=300,
    )
