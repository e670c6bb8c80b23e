"""The bob in the plane, x(t) and y(t): the linear pendulum beside the non-linear one."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.rod_tension import bob_place
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.measurements import case, largest
from plumbob.reports.analyses.simple_pendulum.notebook import (
    CASES,
    DURATION,
    LINEAR,
    SIMPLE,
    own_run,
)
from plumbob.reports.view.content import Figure, Finding, Statement, Table, row, value
from plumbob.reports.view.notation import number
from plumbob.reports.view.palette import BLUE, GREY, RED
from plumbob.reports.view.sources import NOTEBOOK
from plumbob.reports.view.traces import Trace, curve, figure, linear, marks, over_time

DRAWN, SHOWN = "free-large", 6.0  # case 2, and its first seconds
APART = 0.1  # of the length: what a picture of the two shows
FINE = np.linspace(0.0, DURATION, 5001)  # [s]
KINDS = ((SIMPLE, "non-linear", BLUE, "solid"), (LINEAR, "linear", RED, "dash"))


def place(scene: str, times: Array) -> Array:
    """x and y of the bob [m], shape (n, 2), of the exact motion at `times` [s], shape (n,)."""
    posed = case(scene)
    return bob_place(posed.problem.length, posed.reference.observe(times)["theta"])


def distances(times: Array, name: str) -> Array:
    """Distance [m] of the two bobs of a case at `times` [s], shape (n,)."""
    apart = place(SIMPLE + name, times) - place(LINEAR + name, times)
    return np.asarray(np.hypot(*apart.T))


def finding(study: Study) -> Finding:
    """How far the two bobs are apart in each case, and both in the plane."""
    rows, when = [], {}
    for label, name, start in CASES:
        apart, length = distances(FINE, name), case(SIMPLE + name).problem.length
        over = np.flatnonzero(apart > APART * length)
        when[label] = float(FINE[over[0]]) if over.size else math.inf
        rows.append(row(label, start, value(largest(partial(distances, name=name), FINE)),
                        value(when[label] if over.size else None)))  # fmt: skip
    return Finding(
        "notebook-bob",
        "The bob in the plane: the linear pendulum beside the non-linear one",
        "extended",
        "Beyond small angles the bob of the linear pendulum is soon somewhere else. "
        f"In case 2 the two bobs are {number(100 * APART)} cm apart after "
        f"{number(when['2'], 2)} s, and on opposite sides within three periods; in cases 1 and 5 "
        "never.",
        (
            "The notebook works out X₁ = –L sin θ and X₂ = L cos θ, gives them to the function "
            "that plots, and draws neither. Here y points up and θ goes towards +x: x = L sin θ, "
            "y = –L cos θ. The linear equation has no rod: its θ is an angle all the same, and in "
            "case 4 its bob would swing over the top and back.",
        ),
        (Table(f"Distance of the two bobs within {DURATION:g} s", ("case", "start", "largest [m]",
               f"first above {number(100 * APART)} cm [s]"), tuple(rows)),),
        (*(_over_time(study, axis) for axis in (0, 1)), _plane()),
        tuple(f"plumbob solve {kind}{DRAWN} --times 1,2,3" for kind in (SIMPLE, LINEAR)),
        (
            Statement(
                NOTEBOOK,
                "X₁, X₂",
                "Place of the bob",
                "X₁ = –L sin θ, X₂ = L cos θ",
                "x = L sin θ, y = –L cos θ, drawn for both pendulums",
                "extended",
            ),),
    )  # fmt: skip


def _over_time(study: Study, axis: int) -> Figure:
    letter, times = "xy"[axis], np.linspace(0.0, SHOWN, 240)
    traces: list[Trace] = []
    for prefix, kind, colour, dash in KINDS:
        places = place(prefix + DRAWN, times)[:, axis]
        traces.append(curve(times, places, colour=colour, dash=dash, name=f"{kind}, exact"))
        if (run := study.recording(own_run(prefix + DRAWN))) is not None:
            kept = np.flatnonzero(run.times <= SHOWN)[::2]
            length = case(prefix + DRAWN).problem.length
            dots = bob_place(length, run.observables["theta"][kept])[:, axis]
            traces.append(
                {
                    **marks(run.times[kept], dots, GREY, "notebook's RK4", size=3.5),
                    "showlegend": prefix == LINEAR,
                }
            )
    return over_time(
        f"{letter}(t) of case 2",
        f"The first {SHOWN:g} s of the large swing.",
        traces,
        linear(f"{letter} [m]"),
        height=300,
    )


def _plane() -> Figure:
    times = np.linspace(0.0, SHOWN, 240)
    traces: list[Trace] = []
    for prefix, kind, colour, dash in KINDS:
        x, y = place(prefix + "rotating-fast", times).T
        part = 1.0 if prefix == SIMPLE else 0.97  # else one circle covers the other
        traces.append(curve(part * x, part * y, colour=colour, dash=dash, name=kind))
    return figure(
        "Paths of case 4",
        "The pendulum goes round; the linear one, drawn a little inside, swings by 200° each way.",
        traces,
        linear("x [m]"),
        linear("y [m]", scaleanchor="x"),
        legend=True,
        height=300,
    )
