"""The finding on how fast repeated manoeuvres can go: the optimum in closed form, and engines."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from plumbob.analytic.systems.manoeuvres.mean_speed import (
    fastest,
    fastest_speed,
    longest_stroke,
    mean_speed,
)
from plumbob.analytic.systems.manoeuvres.repeated_line import RepeatedLine
from plumbob.engines.study.extra_runs import Changes, ExtraRun
from plumbob.engines.study.results import Study
from plumbob.models.tripod_capsule.parameters import CHECK, capsule
from plumbob.reports.view.content import Figure, Finding, Statement, Table, method_cell, row, value
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.palette import GREY, OLIVE, PERIWINKLE, RED
from plumbob.reports.view.sources import CHERNOUSKO
from plumbob.reports.view.traces import Trace, curve, figure, linear, logarithmic

SCENE, STEP, COUNT = "capsule-train/ten", 1e-3, 5
METHODS = ("mujoco/euler+coulomb", "mujoco/euler+reduced", "pymunk/side", "pymunk/feet")
STROKE, PUSH = 0.2, 10.0  # [m], and w1 over f g/mu
BRAKES = ((1.0, RED), (0.5, OLIVE), (0.1, PERIWINKLE))  # w2 over f g/mu


@cache
def best() -> RepeatedLine:
    """The fastest manoeuvres of STROKE with w1 of PUSH f g/mu, started on the grid of steps."""
    body = capsule(CHECK)
    line = fastest(body, PUSH * body.holding_acceleration, STROKE)
    lasting = RepeatedLine(line, COUNT).period
    return RepeatedLine(line, COUNT, 1.0, math.ceil(lasting / STEP) * STEP - lasting)


def changes() -> Changes:
    """The same as changes of SCENE."""
    manoeuvre = best().manoeuvre
    parameters = {name: getattr(manoeuvre, name) for name in ("w1", "w2", "t1", "start")}
    return (*parameters.items(), ("count", COUNT), ("fraction", 1.0), ("pause", best().pause))


def request(method: str) -> ExtraRun:
    """The run of the fastest manoeuvres with a method."""
    lasting = COUNT * round(best().period / STEP) * STEP
    return ExtraRun(SCENE, method, STEP, lasting, changes())


def finding(study: Study) -> Finding:
    """The optimum and its limit, with the engines at it."""
    body, many = capsule(CHECK), best()
    low, high = longest_stroke(body, 0.0)
    limit, most = fastest_speed(body, STROKE), fastest_speed(body, high - low)
    rows = []
    for method in METHODS:
        if request(method) in study.extras and (run := study.recording(request(method))):
            mean = abs(float(run.observables["displacement"][-1] / run.times[-1]))
            rows.append(row(method_cell(method), value(mean, 6), value(mean / many.mean_speed - 1)))
    tables = [
        Table("Mean speeds of the check body along C–A₁", ("manoeuvres", "stroke [m]", "V [m/s]"), (
            row("the check manoeuvre, return at 0.9 f g/μ", value(0.0817786),
                value(mean_speed(body, 3 * body.holding_acceleration,
                                 0.8 * body.holding_acceleration, 0.0817786125, 0.9), 5)),
            row(f"w₁ = {number(PUSH)} f g/μ, w₂ = f g/μ", value(STROKE),
                value(RepeatedLine(many.manoeuvre, 1).mean_speed, 5)),
            row("w₁ without bound", value(STROKE), value(limit, 5)),
            row("and the stroke too", value(high - low), value(most, 5)),
        )),
    ]  # fmt: skip
    if rows:
        heads = ("method", "mean speed [m/s]", "relative error")
        exact = f"Exact, with a pause to the next step: {number(many.mean_speed, 6)} m/s."
        title = f"{COUNT} of the fastest manoeuvres, step {short(STEP)} s"
        tables.append(Table(title, heads, tuple(rows), exact))
    return Finding(
        "capsule-mean-speed",
        "The mean speed has its optimum at the bounds, in closed form",
        "extended",
        "The fastest walk is known in closed form and need not be searched for. "
        f"With a stroke of {number(STROKE)} m the check body goes at most {number(limit)} m/s on "
        f"average; with the longest that keeps all Nᵢ above zero, {number(most)} m/s.",
        (
            "With x = fg/(μw₁) and y = fg/(μw₂), a stroke L and a slow return at the fraction p of "
            "fg/μ, eqs. 17, 18, 21 and 22 give V = √(μfgL) (1–x)/(1+y) / (√(2(x+y)) + 2/√p). It "
            "falls with x and y and grows with p and L, so there is no optimum inside: brake and "
            "return with all the friction there is, y = p = 1, push as hard as the actuator can, "
            "and use the whole stroke. As x → 0, V → √(μfgL)/(2√2 + 4).",
            "The longest stroke is the chord d of the triangle on the line, over μ (a finding of "
            "its own): V is then below 0.146 √(fgd), whatever the masses.",
        ),
        tuple(tables),
        (_figure(limit),),
        ("plumbob solve capsule-train/ten",),
        (
            Statement(
                CHERNOUSKO,
                "after (22)",
                "Motions with the greatest mean speed have been found",
                "no value",
                f"at most {number(limit)} m/s with a stroke of {number(STROKE)} m, {number(most)} "
                "m/s with the longest",
                "extended",
            ),
        ),
    )


def _figure(limit: float) -> Figure:
    body = capsule(CHECK)
    holding = body.holding_acceleration
    pushes = np.geomspace(1.001, 100.0, 120)
    traces: list[Trace] = [
        curve(
            pushes,
            [mean_speed(body, p * holding, brake * holding, STROKE) for p in pushes],
            colour=colour,
            name=f"w₂ = {number(brake)} f g/μ",
        )
        for brake, colour in BRAKES
    ]
    ends = pushes[[0, -1]]
    traces.append(curve(ends, [limit, limit], colour=GREY, dash="dash", name="the limit"))
    return figure(
        "Mean speed over the push",
        f"A stroke of {number(STROKE)} m, the return at f g/μ.",
        traces,
        logarithmic("w₁ over f g/μ"),
        linear("V [m/s]"),
        legend=True,
        height=300,
    )
