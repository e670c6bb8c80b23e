"""The finding that a control read at a step's start costs an order, and where it comes back."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.results import Study
from plumbob.reports.findings.simple_pendulum.problems import SIMPLE, number, order_text, refined
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Figure, Finding, Table, row
from plumbob.reports.view.palette import styles
from plumbob.reports.view.traces import curve, figure, logarithmic, positive

SCENE = f"{SIMPLE}forced-large"
STEPS, DURATION = (2e-2, 1e-2, 5e-3, 2.5e-3), 10.0  # of a convergence_study of one's own
READ: Mapping[str, str] = MappingProxyType(
    {
        "ode/rk4": "at its own stages: start, middle, end",
        "mujoco/rk4": "at the step's start, and held",
        "mujoco/rk4+midpoint": "at the step's middle, and held",
        "mujoco/euler": "at the step's start, and held",
        "mujoco/euler+midpoint": "at the step's middle, and held",
    }
)


def finding(study: Study) -> Finding:
    """Orders of the forced case by how the control is read, with what theory says of each."""
    own = {m: c for m in READ if (c := refined(study, SCENE, m, STEPS, DURATION)) is not None}
    rows = []
    for method, found in own.items():
        done = {m.step: m.errors["theta"].largest for m in found.measurements if m.status == "done"}
        at = min(done, key=lambda h: abs(h - 5e-3)) if done else None
        told = found.predicted_order
        rows.append(
            row(
                Cell(method, "method"),
                READ[method],
                Cell(order_text(found.order), "number"),
                Cell(f"{told.slope:.3f}" if told else "–", "number"),
                number(done[at] if at else None),
                Cell(f"{notation.short(at)} s" if at else "–", "number"),
            )
        )
    slopes = {m: c.order.slope for m, c in own.items() if c.order}
    said = ", ".join(
        f"{slopes[m]:.2f} {where}"
        for m, where in (
            ("mujoco/rk4", "with the control read at the step's start"),
            ("mujoco/rk4+midpoint", "with the one of its middle"),
            ("ode/rk4", "where the force is asked for at every stage"),
        )
        if m in slopes
    )
    return Finding(
        "held-control",
        "A control read at the step's start costs RK4 three orders; read at the middle, two",
        "engine limit",
        f"A pendulum pushed by A sin(Ωt): RK4's observed order is {said}.",
        (
            "MuJoCo reads ctrl once a step and holds it, through all four stages of RK4. Held from "
            "the start, the push lags by half a step: an error of first order, whatever the "
            "integrator. Held at its value in the middle, the push is right on average over the "
            "step: second order. The methods with +midpoint set ctrl to the value at t + h/2; it "
            "costs nothing. Euler stays of first order either way.",
            "A force that a user applies from a Python loop once a step (xfrc_applied, "
            "qfrc_applied, a controller's torque) is held in the same way.",
        ),
        (
            Table(
                f"Observed order in {SCENE}, by where the push is read",
                ("method", "push is read", "observed [95 % interval]", "predicted here",
                 "error [rad]", "at step"),
                tuple(rows),
            ),
        ),
        (_plot(own),),
        tuple(f"plumbob run {SCENE} {m} --step 5e-3" for m in
              ("mujoco/rk4", "mujoco/rk4+midpoint", "ode/rk4")),
    )  # fmt: skip


def _plot(own: Mapping[str, ConvergenceStudy]) -> Figure:
    style = styles([find_method(m) for m in READ])
    traces = []
    for method, found in own.items():
        done = [m for m in found.measurements if m.status == "done"]
        traces.append(
            curve([m.step for m in done], positive([m.errors["theta"].largest for m in done]),
                  style[method], method=method, marks=True)
        )  # fmt: skip
    return figure(
        "One integrator, three ways to read a push",
        f"Largest error of θ in {SCENE}.",
        traces,
        logarithmic("step [s]"),
        logarithmic("largest |error of θ| [rad]"),
        legend=True,
        wide=True,
        height=340,
    )
