"""The notebook's seven cases: its plots beside the exact answer, and what its method errs by."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.findings.fresh_runs import run
from plumbob.reports.findings.simple_pendulum.problems import (
    CASES,
    LINEAR,
    SIMPLE,
    case,
    measured,
    number,
)
from plumbob.reports.view import notation
from plumbob.reports.view.content import Figure, Finding, Table, row
from plumbob.reports.view.traces import Trace, curve, figure, linear

METHOD, STEP, DURATION = "ode/rk4", 0.05, 50.0  # the notebook's: 1000 steps
SHOWN = 15.0  # [s] of an undamped motion, the rest of which is the same again
POINTS = 300
DOTS = 3  # steps from one dot to the next: 0.15 s
BLUE, ORANGE, GREY = "#0072b2", "#d55e00", "#808080"


@cache
def notebook(scene: str) -> Trajectory | None:
    """The notebook's own run of a scene."""
    return run(scene, METHOD, STEP, DURATION)


def galleries() -> Sequence[tuple[str, Sequence[Figure]]]:
    """For each case theta(t) and the phase plane, linear and non-linear, exact and by RK4."""
    return tuple(
        (f"Case {label} of the notebook: {start}", _pair(name)) for label, name, start in CASES
    )


def _pair(name: str) -> Sequence[Figure]:
    problem = case(SIMPLE + name).problem
    until = DURATION if problem.damping_rate else SHOWN
    course: list[Trace] = []
    plane: list[Trace] = []
    for prefix, kind, colour, dash in (
        (SIMPLE, "non-linear", BLUE, "solid"),
        (LINEAR, "linear", ORANGE, "dash"),
    ):
        for paths, end in ((course, until), (plane, SHOWN)):
            times = np.linspace(0.0, end, POINTS)
            x, y = _path(prefix, times, case(prefix + name).exact.observe(times), paths is plane)
            paths.append(curve(x, y, colour=colour, dash=dash, name=f"{kind}, exact"))
            if (found := notebook(prefix + name)) is not None:
                kept = np.flatnonzero(found.times <= end)[::DOTS]
                seen = {n: values[kept] for n, values in found.observables.items()}
                x, y = _path(prefix, found.times[kept], seen, paths is plane)
                paths.append(_dotted(x, y, prefix == LINEAR))
    span = f"The first {until:g} s" if until < DURATION else f"All {until:g} s"
    turns = "; a turn of the pendulum leads back to the left edge" if problem.theta_dot else ""
    dots = f"Dots: the notebook's RK4, every {STEP * DOTS:g} s"
    return (
        figure("θ(t)", f"{span}. {dots}.", course, linear("time [s]"), linear("θ [rad]"),
               legend=True, height=300),
        figure("Phase plane", f"The first {SHOWN:g} s{turns}.", plane, linear("θ [rad]"),
               linear("dθ/dt [rad/s]"), legend=True, height=300),
    )  # fmt: skip


def _dotted(x: Array, y: Array, named: bool) -> Trace:
    """Small dots; the name of both kinds stands in the legend once."""
    dots = curve(x, y, colour=GREY, lines=False, marks=True, name="RK4")
    return {**dots, "marker": {**dots["marker"], "size": 3.5}, "showlegend": named}


def _path(
    prefix: str, times: Array, seen: Mapping[str, Array], in_plane: bool
) -> tuple[Array, Array]:
    """Where a motion goes: over time, or in the phase plane."""
    if not in_plane:
        return times, seen["theta"]
    return _wound(seen["theta"], seen["theta_dot"], prefix == SIMPLE)


def _wound(theta: Array, rate: Array, pendulum: bool) -> tuple[Array, Array]:
    """A path in the phase plane; a pendulum's between -pi and pi, broken where it leaves."""
    if not pendulum:
        return theta, rate
    turns = np.round(theta / (2 * np.pi))
    inside = theta - 2 * np.pi * turns
    breaks = np.flatnonzero(np.diff(turns)) + 1
    return np.insert(inside, breaks, np.nan), np.insert(rate, breaks, np.nan)


def finding(study: Study) -> Finding:
    """What RK4 at dt 0.05 errs by after a thousand steps, for each case."""
    rows, largest = [], {}
    for label, name, start in CASES:
        error, told = _error(study, SIMPLE + name)
        of_linear, _ = _error(study, LINEAR + name)
        largest[label] = error
        rows.append(
            row(label, name, start, number(error), number(told), number(of_linear),
                number(_apart(name)))
        )  # fmt: skip
    heads = ("case", "scene", "start", "error of RK4 [rad]", "predicted [rad]",
             "error of RK4, linear [rad]", "linear from non-linear [rad]")  # fmt: skip
    least, most = min(largest, key=lambda c: largest[c]), max(largest, key=lambda c: largest[c])
    worse = round(largest[most] / largest[least], -2)
    return Finding(
        "notebook-rk4",
        "What the notebook's own RK4 errs by: 2e-5 to 6e-2 rad, as theory predicts",
        "measured",
        f"RK4 with dt 0.05 s errs over 50 s by {notation.number(largest[least])} rad in case "
        f"{least} and by {notation.number(largest[most])} rad in case {most}; the linear equation "
        "is the larger error in all seven.",
        (
            "The notebook shows curves and no error. The same integrator at the same step, held "
            f"against the exact motion, is some {worse:.0f} times worse in case {most} than in "
            f"case {least}: where nothing damps, RK4's energy drift changes the speed, and the "
            "angle runs away with time; where something does, its errors die with the motion.",
        ),
        (
            Table(
                "RK4 at dt 0.05 s, 1000 steps: largest error of θ",
                heads,
                tuple(rows),
                "Prediction: C₄h⁴ + C₅h⁵ + …, where the study ran the case. Last column: largest "
                "difference of the two exact motions.",
            ),
        ),
        (),
        (
            f"plumbob run {SIMPLE}rotating-fast {METHOD} --step {STEP}",
            f"plumbob run {LINEAR}rotating-fast {METHOD} --step {STEP}",
        ),
    )


def _error(study: Study, scene: str) -> tuple[float, float | None]:
    """Largest error [rad] of the notebook's run, and what is predicted of it."""
    if (known := measured(study, scene, METHOD, STEP)) is not None:
        error = known.errors["theta"]
        return error.largest, error.predicted.largest if error.predicted else None
    found = notebook(scene)
    if found is None:
        return float("nan"), None
    truth = case(scene).exact.observe(found.times)["theta"]
    return float(np.abs(found.observables["theta"] - truth).max()), None


def _apart(name: str) -> float:
    """Largest difference [rad] of the linear motion from the non-linear one."""
    times = np.linspace(0.0, DURATION, 1001)
    one, other = (case(prefix + name).exact.observe(times)["theta"] for prefix in (SIMPLE, LINEAR))
    return float(np.abs(one - other).max())
