"""The notebook's seven cases: its plots beside the exact answer, and the errors of its method."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.measurements import case, largest, scheme
from plumbob.reports.view.content import Claim, Figure, Finding, Statement, Table, row, value
from plumbob.reports.view.notation import number
from plumbob.reports.view.palette import BLUE, GREY, RED
from plumbob.reports.view.sources import NOTEBOOK
from plumbob.reports.view.traces import Trace, curve, figure, linear, marks, over_time

SIMPLE, LINEAR = "simple-pendulum/", "linear-pendulum/"
METHOD, STEP, DURATION = "ode/rk4", 0.05, 50.0  # the notebook's: 1000 steps
EVERY_STEP = np.linspace(0.0, DURATION, 1001)  # [s]
SHOWN = 15.0  # [s] of an undamped motion, the rest of which is the same again
POINTS = 300
DOTS = 3  # steps from one dot to the next: 0.15 s
CASES = (
    ("1", "free-small", "θ₀ = –10°, from rest"),
    ("2", "free-large", "θ₀ = –120°, from rest"),
    ("3", "rotating-slow", "θ₀ = –120°, at 200°/s"),
    ("4", "rotating-fast", "θ₀ = –120°, at 500°/s"),
    ("5", "damped-small", "θ₀ = –10°, ξ = 0.08/s"),
    ("6", "damped-large", "θ₀ = –120°, ξ = 0.08/s"),
    ("7", "damped-rotating", "θ₀ = –120°, at 500°/s, ξ = 0.2/s"),
)
FORCED = ("forced-small", "forced-large", "forced-chaotic")


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The notebook's own run of each case, non-linear and linear."""
    return [own_run(prefix + name) for _, name, _ in CASES for prefix in (SIMPLE, LINEAR)]


def own_run(scene: str) -> ExtraRun:
    """The notebook's own run of a scene."""
    return ExtraRun(scene, METHOD, STEP, DURATION)


def galleries(study: Study) -> Sequence[tuple[str, Sequence[Figure]]]:
    """For each case theta(t) and the phase plane, linear and non-linear, exact and by RK4."""
    return tuple(
        (f"Case {label} of the notebook: {start}", _pair(study, name))
        for label, name, start in CASES
    )


def _pair(study: Study, name: str) -> Sequence[Figure]:
    problem = case(SIMPLE + name).problem
    until = DURATION if problem.damping_rate else SHOWN
    course: list[Trace] = []
    plane: list[Trace] = []
    for prefix, kind, colour, dash in (
        (SIMPLE, "non-linear", BLUE, "solid"),
        (LINEAR, "linear", RED, "dash"),
    ):
        for paths, end in ((course, until), (plane, SHOWN)):
            times = np.linspace(0.0, end, POINTS)
            x, y = _path(
                prefix, times, case(prefix + name).reference.observe(times), paths is plane
            )
            paths.append(curve(x, y, colour=colour, dash=dash, name=f"{kind}, exact"))
            if (run := study.recording(own_run(prefix + name))) is not None:
                kept = np.flatnonzero(run.times <= end)[::DOTS]
                samples = {n: values[kept] for n, values in run.observables.items()}
                x, y = _path(prefix, run.times[kept], samples, paths is plane)
                paths.append(_dotted(x, y, prefix == LINEAR))
    span = f"The first {until:g} s" if until < DURATION else f"All {until:g} s"
    turns = "; after a full turn the curve continues at the left edge" if problem.theta_dot else ""
    dots = f"Dots: the notebook's RK4, every {STEP * DOTS:g} s"
    return (
        over_time("θ(t)", f"{span}. {dots}.", course, linear("θ [rad]"), height=300),
        figure("Phase plane", f"The first {SHOWN:g} s{turns}.", plane, linear("θ [rad]"),
               linear("dθ/dt [rad/s]"), legend=True, height=300),
    )  # fmt: skip


def _dotted(x: Array, y: Array, named: bool) -> Trace:
    """Small dots; the name of both kinds stands in the legend once."""
    return {**marks(x, y, GREY, "RK4", size=3.5), "showlegend": named}


def _path(
    prefix: str, times: Array, samples: Mapping[str, Array], in_plane: bool
) -> tuple[Array, Array]:
    """The path of a motion: over time, or in the phase plane."""
    if not in_plane:
        return times, samples["theta"]
    return _wound(samples["theta"], samples["theta_dot"], prefix == SIMPLE)


def _wound(theta: Array, rate: Array, pendulum: bool) -> tuple[Array, Array]:
    """A path in the phase plane; a pendulum's between -pi and pi, broken where it leaves."""
    if not pendulum:
        return theta, rate
    turns = np.round(theta / (2 * np.pi))
    inside = theta - 2 * np.pi * turns
    breaks = np.flatnonzero(np.diff(turns)) + 1
    return np.insert(inside, breaks, np.nan), np.insert(rate, breaks, np.nan)


def finding(study: Study) -> Finding:
    """The error of RK4 at dt 0.05 over a thousand steps, for each case."""
    rows, largest = [], {}
    for label, name, start in CASES:
        error, predicted = _error(study, SIMPLE + name)
        of_linear, _ = _error(study, LINEAR + name)
        largest[label] = error
        rows.append(
            row(label, name, start, value(error), value(predicted), value(of_linear),
                value(_difference(name)))
        )  # fmt: skip
    heads = ("case", "scene", "start", "error of RK4 [rad]", "predicted [rad]",
             "error of RK4, linear [rad]", "linear less non-linear motion [rad]")  # fmt: skip
    linear = {label: _difference(name) for label, name, _ in CASES}
    best, worst = min(largest, key=lambda c: largest[c]), max(largest, key=lambda c: largest[c])
    factor = round(largest[worst] / largest[best], -2)
    return Finding(
        "notebook-rk4",
        "The error of the notebook's own RK4: 2e-5 to 6e-2 rad, as theory predicts",
        "measured",
        "The notebook's step is small enough: to leave out sin θ is the larger error. "
        f"Over 50 s the error of RK4 with dt 0.05 s is {number(largest[best])} rad in case {best} "
        f"and {number(largest[worst])} rad in case {worst}; using the linear equation is the "
        "larger error in all seven.",
        (
            "The notebook shows curves and no error. The same integrator at the same step, "
            f"compared with the exact motion, has an error about {factor:.0f} times larger in case "
            f"{worst} than in case {best}: without damping, RK4's energy drift changes the speed, "
            "and the error of the angle grows with time; with damping, errors decay too.",
        ),
        (
            Table(
                "RK4 at dt 0.05 s, 1000 steps: largest error of θ",
                heads,
                tuple(rows),
                "Predicted: what theory says of steps of 0.05 s. Last column: largest difference "
                "of the two exact motions.",
            ),
        ),
        (),
        (
            f"plumbob run {SIMPLE}rotating-fast {METHOD} --step {STEP}",
            f"plumbob run {LINEAR}rotating-fast {METHOD} --step {STEP}",
        ),
        (
            Statement(
                NOTEBOOK,
                "integrator",
                "The equations integrated by RK4",
                "dt 0.05 s, 1000 steps; no error given",
                f"error {number(largest[best])} rad (case {best}) to {number(largest[worst])} rad "
                f"(case {worst})",
                "extended",
            ),
        ),
        claims=tuple(
            Claim(
                f"in case {label} the error of RK4 is {number(largest[label])} rad, of the linear "
                f"equation {number(of)} rad",
                not largest[label] >= of,
            )
            for label, of in linear.items()
        ),
    )


def _error(study: Study, scene: str) -> tuple[float, float | None]:
    """Largest error [rad] of the notebook's run at any of its steps, and what theory predicts."""
    run, posed = study.recording(own_run(scene)), case(scene)
    if run is None:
        return float("nan"), None
    truth = posed.reference.observe(run.times)
    theta, rate = (run.observables[name] - truth[name] for name in ("theta", "theta_dot"))
    error = float(np.abs(at_every_step(run.times, theta, rate)).max())
    predicted = posed.errors.at_step(scheme(METHOD), STEP, EVERY_STEP).errors["theta"]
    return error, float(np.abs(predicted).max())


def at_every_step(times: Array, theta: Array, rate: Array) -> Array:
    """Angles [rad] after each step of a run of the notebook's, shape (1001,): a recording has every
    second one, at `times` [s], and rates [rad/s], which give those between by a cubic."""
    from scipy.interpolate import CubicHermiteSpline

    return np.asarray(CubicHermiteSpline(times, theta, rate)(EVERY_STEP))


def difference(times: Array, name: str) -> Array:
    """Non-linear less linear angle [rad] of a case's exact motions at `times` [s], shape (n,)."""
    nonlinear, linear = (
        case(prefix + name).reference.observe(times)["theta"] for prefix in (SIMPLE, LINEAR)
    )
    return np.asarray(nonlinear - linear)


def _difference(name: str) -> float:
    """Largest difference [rad] of the linear motion from the non-linear one."""
    return largest(partial(difference, name=name), EVERY_STEP)
