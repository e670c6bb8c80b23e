"""The notebook's seven cases: its plots beside the exact answer, and what its method errs by."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from analytic.reference import Array
from engines.study import Study
from engines.trajectory import Trajectory
from reports import notation
from reports.content import Figure, Finding, Table, row
from reports.fresh_runs import run
from reports.sections.simple_pendulum.problems import (
    CASES,
    LINEAR,
    SIMPLE,
    case,
    measured,
    number,
)
from reports.traces import Trace, curve, figure, linear

METHOD, STEP, DURATION = "ode/rk4", 0.05, 50.0  # the notebook's: 1000 steps
SHOWN = 15.0  # [s] of an undamped motion: the rest is the same again
POINTS = 300
DOTS = 4  # steps from one dot to the next: 0.2 s
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
        times = np.linspace(0.0, until, POINTS)
        seen = case(prefix + name).exact.observe(times)
        for paths, (x, y) in _both(times, seen["theta"], seen["theta_dot"], course, plane, prefix):
            paths.append(curve(x, y, colour=colour, dash=dash, name=f"{kind}, exact"))
        if (found := notebook(prefix + name)) is not None:
            kept = np.flatnonzero(found.times <= until)[::DOTS]
            angle, speed = (found.observables[n][kept] for n in ("theta", "theta_dot"))
            for paths, (x, y) in _both(found.times[kept], angle, speed, course, plane, prefix):
                dotted = curve(x, y, colour=GREY, lines=False, marks=True, name=f"{kind}, RK4")
                paths.append({**dotted, "marker": {**dotted["marker"], "size": 3.5}})
    span = f"The first {until:g} s" if until < DURATION else f"All {until:g} s"
    return (
        figure("θ(t)", f"{span}; dots: the notebook's RK4, every {STEP * DOTS:g} s.", course,
               linear("time [s]"), linear("θ [rad]"), legend=True, height=300),
        figure("Phase plane", "A turn of the pendulum leads back to the left edge." if
               np.abs(course[0]["y"]).max() > np.pi else "Where the motion goes, and how fast.",
               plane, linear("θ [rad]"), linear("dθ/dt [rad/s]"), legend=True, height=300),
    )  # fmt: skip


def _both(
    times: Array, theta: Array, rate: Array, course: list[Trace], plane: list[Trace], prefix: str
) -> Sequence[tuple[list[Trace], tuple[Array, Array]]]:
    """Where a motion goes in either figure, and its path there."""
    return (course, (times, theta)), (plane, _wound(theta, rate, prefix == SIMPLE))


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
    heads = ("case", "scene", "start", "error of RK4 [rad]", "foretold [rad]",
             "error of RK4, linear [rad]", "linear from non-linear [rad]")  # fmt: skip
    least, most = min(largest, key=lambda c: largest[c]), max(largest, key=lambda c: largest[c])
    worse = notation.number(largest[most] / largest[least], 2)
    return Finding(
        "notebook-rk4",
        "What the notebook's own RK4 errs by: 2e-5 to 6e-2 rad, as theory foretells",
        "measured",
        f"RK4 with dt 0.05 s errs over 50 s by {notation.number(largest[least])} rad in case "
        f"{least} and by {notation.number(largest[most])} rad in case {most}; the linear equation "
        "is the larger error in all seven.",
        (
            "The notebook shows curves and no error. The same integrator at the same step, held "
            "against the exact motion, is some "
            f"{worse} times worse in case {most} than in case {least}: where nothing damps, RK4's "
            "energy drift changes the speed, and the angle runs away with time; where something "
            "does, its errors die with the motion.",
        ),
        (
            Table(
                "RK4 at dt 0.05 s, 1000 steps: largest error of θ",
                heads,
                tuple(rows),
                "Foretold: C₄h⁴ + C₅h⁵ + …, where the study ran the case. Last column: largest "
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
    """Largest error [rad] of the notebook's run, and what is foretold of it."""
    if (known := measured(study, scene, METHOD, STEP)) is not None:
        error = known.errors["theta"]
        return error.largest, error.foretold.largest if error.foretold else None
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
