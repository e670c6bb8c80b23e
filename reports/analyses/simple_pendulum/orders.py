"""The order of RK4 with a held control, observed and predicted."""

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
"""Range of RK4's order with a control held from the start of a step, held from mid-step, and read
at every stage."""


def held_control(study: Study) -> Record | None:
    """Returns the orders of the forced case for each way of reading the control, observed and
    predicted; None if the study lacks the case."""
    studies = {method: convergence_of(study, FORCED_LARGE, method) for method in READ}
    orders = {method: _observed_order(series) for method, series in studies.items() if series}
    return Record(by_method=orders, methods=READ) if orders else None


def _observed_order(series: ConvergenceStudy) -> Record:
    """Returns the order of a method in the forced case, and its errors of theta [rad] by step
    [s]."""
    done = [run for run in series.measurements if run.status == "done"]
    errors = {run.step: run.errors["theta"].largest for run in done}
    shown = min(errors.items(), key=lambda entry: abs(entry[0] - SHOWN_STEP), default=None)
    return Record(
        order=series.order,
        predicted=series.predicted_order,
        steps=tuple(errors),
        errors=tuple(errors.values()),
        shown=shown,  # step [s] nearest to SHOWN_STEP, and its error
    )


def held_claims(control: Record) -> Claims:
    """Returns the checks that a held control reduces RK4's order by three, and one held from
    mid-step by two."""
    checks = []
    for method, (low, high) in EXPECTED.items():
        observed = control.by_method.get(method)
        if observed and observed.order:
            checks.append(between(f"the order of {method}", observed.order.slope, low, high))
    return checks


HELD_CONTROL = Analysis("simple_pendulum/held_control", held_control, claims=held_claims)
