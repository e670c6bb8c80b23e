"""Observed orders beside those that theory predicts, and what a held control costs."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, between
from plumbob.reports.analyses.measurements import convergence_of
from plumbob.reports.analyses.simple_pendulum.notebook import SIMPLE

FORCED_LARGE = f"{SIMPLE}forced-large"
SHOWN_STEP = 5e-3  # [s]
READ = (
    "ode/rk4",
    "mujoco/rk4",
    "mujoco/rk4+midpoint",
    "mujoco/euler",
    "mujoco/euler+midpoint",
)
EXPECTED: Mapping[str, tuple[float, float]] = MappingProxyType(
    {"mujoco/rk4": (0.5, 1.5), "mujoco/rk4+midpoint": (1.5, 2.5), "ode/rk4": (3.0, 5.0)}
)
"""The range of the order of RK4 with a control that is held, held from mid-step, and followed."""


def held_control(study: Study) -> Record | None:
    """Orders of the forced case by how the control is read, with what theory says of each; None
    where the study does not have it."""
    every = {method: convergence_of(study, FORCED_LARGE, method) for method in READ}
    orders = {m: _control_order(of) for m, of in every.items() if of}
    return Record(by_method=orders, methods=READ) if orders else None  # whose styles are drawn


def _control_order(of: ConvergenceStudy) -> Record:
    """The order of a method in the forced case, and its errors of theta [rad] by step [s]."""
    errors = {m.step: m.errors["theta"].largest for m in of.measurements if m.status == "done"}
    shown = min(errors.items(), key=lambda entry: abs(entry[0] - SHOWN_STEP), default=None)
    steps = tuple(errors)
    sizes = tuple(errors.values())
    return Record(
        order=of.order,
        predicted=of.predicted_order,
        steps=steps,
        errors=sizes,
        shown=shown,  # step and error next to SHOWN_STEP
    )


def held_claims(control: Record) -> Claims:
    """RK4's order is reduced by three, and by two."""
    return [
        between(f"the order of {method}", of.order.slope, *bounds)
        for method, bounds in EXPECTED.items()
        if (of := control.by_method.get(method)) and of.order
    ]


HELD_CONTROL = Analysis("simple_pendulum/held_control", held_control, claims=held_claims)
