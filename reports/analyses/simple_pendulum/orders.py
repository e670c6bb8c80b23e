"""Findings on orders: what theory predicts of each observable, and what a held control costs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.extra_runs import ExtraConvergence, StudyPlan
from plumbob.engines.study.measurement import floor
from plumbob.engines.study.order import Order, fit_order
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.claims import ALIKE, at_most, between
from plumbob.reports.analyses.measurements import convergence_of, order_text, plan_of
from plumbob.reports.analyses.simple_pendulum.notebook import CASES, FORCED, SIMPLE
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Figure, Finding, Table, method_cell, row, value
from plumbob.reports.view.palette import styles
from plumbob.reports.view.traces import curve, figure, logarithmic, positive

METHODS = ("ode/rk4", "ode/leapfrog", "mujoco/euler", "pymunk/default", "pymunk/tight")
REACH = 0.5  # nonlinearity above which an error is no longer a series in the step
Pair = tuple[Order, Order]
FORCED_LARGE = f"{SIMPLE}forced-large"
STEPS, DURATION = (2e-2, 1e-2, 5e-3, 2.5e-3), 10.0  # of an extra convergence study
EXPECTED: Mapping[str, tuple[float, float]] = MappingProxyType(
    {"mujoco/rk4": (0.5, 1.5), "mujoco/rk4+midpoint": (1.5, 2.5), "ode/rk4": (3.0, 5.0)}
)
"""The range of the order of RK4 with a control that is held, held from mid-step, and followed."""
READ: Mapping[str, str] = MappingProxyType(
    {
        "ode/rk4": "at its own stages: start, middle, end",
        "mujoco/rk4": "at the step's start, and held",
        "mujoco/rk4+midpoint": "at the step's middle, and held",
        "mujoco/euler": "at the step's start, and held",
        "mujoco/euler+midpoint": "at the step's middle, and held",
    }
)


def requests(plan: StudyPlan) -> Sequence[ExtraConvergence]:
    """A convergence study of the forced pendulum with each method that the study does not
    run on it itself."""
    return [_extra(method) for method in READ if not plan.has(FORCED_LARGE, method)]


def _extra(method: str) -> ExtraConvergence:
    return ExtraConvergence(FORCED_LARGE, method, STEPS, DURATION)


def _convergence(study: Study, method: str) -> ConvergenceStudy | None:
    """The study's own convergence study of the forced pendulum, or else the extra one; None where
    the engine is missing."""
    if plan_of(study).has(FORCED_LARGE, method):
        return convergence_of(study, FORCED_LARGE, method)
    return study.extra_convergence(_extra(method))


def orders(study: Study) -> Finding | None:
    """Orders of five methods on the study's scenes; None where it fitted none."""
    names = [name for _, name, _ in CASES] + list(FORCED)
    every = {
        n: {m: _fitted(c) for m in METHODS if (c := convergence_of(study, SIMPLE + n, m))}
        for n in names
    }
    shown = {n: fits for n, fits in every.items() if any(fits.values())}
    if not shown:
        return None
    methods = [m for m in METHODS if any(m in fits for fits in shown.values())]
    table = Table(
        "Observed order of the error of θ [95 % interval], and below it the predicted one",
        ("scene", *methods),
        tuple(row(name, *_cells(fits, methods)) for name, fits in shown.items()),
        "Predicted: the same fit to C₁h + C₂h² + … at the same steps h. A dash: fewer than four "
        "steps above round-off and in the range of the series; the full profile takes finer ones.",
    )
    return Finding(
        "orders",
        "The order depends on the motion: RK4 has order 4 or 5, and pymunk order 1 for a reason",
        "confirmed",
        "The order that a method shows depends on the motion and on the quantity; a fitted 5 "
        "of RK4 is no mistake. "
        f"Fitted over four steps or more, the orders are those that theory predicts of this error "
        f"on this motion{_worst(shown)}.",
        (
            "The error of RK4 is C₄h⁴ + C₅h⁵ + …. The first term makes the energy oscillate; by "
            "time symmetry it does not contribute to its drift. The h⁵ term makes it drift: the "
            "error of the speed grows with time, and that of the angle with its square. That term "
            "dominates in cases 2 to 4 at the steps that a user takes. Where the swing is small C₅ "
            "is small, and with damping nothing accumulates: order 4. Leapfrog is symmetric and "
            "has even powers only.",
            "pymunk moves its bodies first and solves the joint's velocities afterwards. With "
            "default settings a joint closes at 6.3/s (error_bias 0.9⁶⁰): while the bob turns the "
            "joint stays open by about h (dθ/dt)² L/13, the rod is longer by that, and closing the "
            "joint takes energy; both are of first order in h, and so is the error. With "
            "error_bias 0 (pymunk/tight) the joint closes in one step: the error of the Euler step "
            "is left, and an opening of second order. The number of iterations changes nothing, "
            "because a single joint is solved exactly at once.",
        ),
        (table,),
        (),
        tuple(
            f"plumbob validate --profile full --scenes {SIMPLE}{name} --methods {','.join(methods)}"
            for name in list(shown)[:2]
        ),
        claims=(
            at_most(
                "the largest difference of an order from the predicted one", _gap(shown), ALIKE
            ),
        ),
    )


def _fitted(series: ConvergenceStudy) -> Pair | None:
    """Observed and predicted order of the error of theta, over the steps in the range of the
    series; None with fewer than four of them above round-off."""
    reached = [
        (m.step, m.errors["theta"], floor(m.errors["theta"], m.steps))
        for m in series.measurements
        if m.status == "done" and (f := m.errors["theta"].predicted) and f.nonlinearity < REACH
    ]
    if not reached:
        return None
    steps, errors, levels = zip(*reached, strict=True)
    observed = fit_order(steps, [e.largest for e in errors], levels)
    if observed is None:
        return None
    same = [
        e.predicted.largest
        for h, e in zip(steps, errors, strict=True)
        if h in observed.steps and e.predicted
    ]
    predicted = fit_order([h for h in steps if h in observed.steps], same, [0.0] * len(same))
    return (observed, predicted) if predicted else None


def _cells(fits: Mapping[str, Pair | None], methods: Sequence[str]) -> list[Cell]:
    cells = []
    for method in methods:
        if (pair := fits.get(method)) is None:
            cells.append(Cell("–", "number", "too few steps in the range of the series"))
            continue
        text = f"{order_text(pair[0])}\n{pair[1].slope:.3f}"
        cells.append(Cell(text, "number", "observed, then predicted"))
    return cells


def _worst(shown: Mapping[str, Mapping[str, Pair | None]]) -> str:
    return f", with a largest difference of {_gap(shown):.3f}"


def _gap(shown: Mapping[str, Mapping[str, Pair | None]]) -> float:
    """The largest difference of an observed order from the predicted one."""
    pairs = [pair for fits in shown.values() for pair in fits.values() if pair]
    return max(abs(observed.slope - predicted.slope) for observed, predicted in pairs)


def held_control(study: Study) -> Finding:
    """Orders of the forced case by how the control is read, with what theory says of each."""
    found_by = {m: c for m in READ if (c := _convergence(study, m)) is not None}
    rows = []
    for method, runs in found_by.items():
        done = {m.step: m.errors["theta"].largest for m in runs.measurements if m.status == "done"}
        at = min(done, key=lambda h: abs(h - 5e-3)) if done else None
        predicted = runs.predicted_order
        rows.append(
            row(
                method_cell(method),
                READ[method],
                Cell(order_text(runs.order), "number"),
                Cell(f"{predicted.slope:.3f}" if predicted else "–", "number"),
                value(done[at] if at else None),
                Cell(f"{notation.short(at)} s" if at else "–", "number"),
            )
        )
    slopes = {m: c.order.slope for m, c in found_by.items() if c.order}
    listed = ", ".join(
        f"{slopes[m]:.2f} {where}"
        for m, where in (
            ("mujoco/rk4", "with the control read at the step's start"),
            ("mujoco/rk4+midpoint", "with the control read at its middle"),
            ("ode/rk4", "where the force is evaluated at every stage"),
        )
        if m in slopes
    )
    return Finding(
        "held-control",
        "A control read at a step's start reduces the order of RK4 by three; at its middle, by two",
        "engine limit",
        "A controller that sets its torque once a step, for the step's start, makes RK4 a "
        "method of first order: set it for the middle. "
        "The pendulum here is pushed by A sin(Ωt)"
        + (f": RK4's observed order is {listed}." if listed else "."),
        (
            "MuJoCo reads ctrl once a step and holds it, through all four stages of RK4. Held from "
            "the start, the push is late by half a step: an error of first order, whatever the "
            "integrator. Held at its value in the middle, the push is right on average over the "
            "step: second order. The methods with +midpoint set ctrl to the value at t + h/2, at "
            "no extra cost. Euler stays of first order either way.",
            "A force that a user applies from a Python loop once a step (xfrc_applied, "
            "qfrc_applied, a controller's torque) is held in the same way.",
        ),
        (
            Table(
                f"Observed order in {FORCED_LARGE}, by where the push is read",
                ("method", "push is read", "observed [95 % interval]", "predicted here",
                 "error [rad]", "at step"),
                tuple(rows),
            ),
        ),
        (_plot(found_by),),
        tuple(f"plumbob run {FORCED_LARGE} {m} --step 5e-3" for m in
              ("mujoco/rk4", "mujoco/rk4+midpoint", "ode/rk4")),
        claims=(
            *(between(f"the order of {method}", slopes[method], low, high)
              for method, (low, high) in EXPECTED.items() if method in slopes),
        ),
    )  # fmt: skip


def _plot(found_by: Mapping[str, ConvergenceStudy]) -> Figure:
    style = styles([find_method(m) for m in READ])
    traces = []
    for method, runs in found_by.items():
        done = [m for m in runs.measurements if m.status == "done"]
        traces.append(
            curve([m.step for m in done], positive([m.errors["theta"].largest for m in done]),
                  style[method], method=method, marks=True)
        )  # fmt: skip
    return figure(
        "One integrator, three ways to read a control",
        f"Largest error of θ in {FORCED_LARGE}.",
        traces,
        logarithmic("step [s]"),
        logarithmic("largest |error of θ| [rad]"),
        legend=True,
        wide=True,
        height=340,
    )
