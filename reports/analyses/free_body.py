"""The page's section on the free body: why MuJoCo's RK4 is of second order on it, and what energy
the Euler steps gain and lose."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from plumbob.analytic.errors.free_body.error_series import euler_drifts
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement, reference_run, worst
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record, Section
from plumbob.reports.analyses.claims import ALIKE, Claims, as_predicted, at_most, between
from plumbob.reports.analyses.measurements import case, convergence_of

RK4: Final = ("mujoco/rk4", "ode/rk4")
EULER: Final = (
    "mujoco/euler",
    "ode/euler",
    "mujoco/implicit",
    "mujoco/implicitfast",
    "mujoco/discrete",
)
SHOWN: Final = ("free-body/flip", "free-body/symmetric")  # scenes that every profile runs


def second_order(study: Study) -> Record | None:
    """The orders of the two RK4s; None where MuJoCo's was not run."""
    terms = tuple(_term(study, of, run) for of, run in _runs(study, RK4))
    of_mujoco = tuple(term for term in terms if term.method == RK4[0])
    return Record(runs=terms, methods=RK4, of_mujoco=of_mujoco) if of_mujoco else None


def _term(study: Study, of: ConvergenceStudy, run: Measurement) -> Record:
    """The relative error of the worst observable in a run, and the term of second order in it."""
    quantity, error = worst(run, study.quantities(of.scene))
    predicted = run.errors[quantity.observable].predicted
    term = None if predicted is None else predicted.terms.get(2, 0.0) / quantity.scale
    return Record(
        scene=of.scene,
        method=of.method,
        step=run.step,  # [s]
        error=error,
        term=term,  # None where nothing is predicted
        order=of.order,
    )


def order_claims(second: Record) -> Claims:
    """MuJoCo's RK4 is of second order, and its error is the predicted term."""
    orders = [
        between(f"the order of {run.method} on {run.scene}", run.order.slope, 1.5, 2.5)
        for run in second.of_mujoco
        if run.order is not None
    ]
    terms = [
        as_predicted(f"the relative error on {run.scene}", run.error, run.term)
        for run in second.of_mujoco
        if run.term is not None
    ]
    return (*orders, *terms)


def energy(study: Study) -> Record | None:
    """The energy that first-order steps gain or lose; None where none of them was run."""
    runs = [pair for pair in _runs(study, EULER) if "energy" in pair[1].invariants]
    errors = tuple(_energy_error(*pair) for pair in runs)
    # the largest distance of a drift from the predicted one, relative
    gaps = (abs(of.drift / abs(of.predicted) - 1.0) for of in errors if of.predicted)
    return Record(runs=errors, gap=max(gaps, default=0.0)) if errors else None


def _energy_error(of: ConvergenceStudy, run: Measurement) -> Record:
    """The relative drift of the energy over a run, and the predicted one with its sign."""
    implicit = "implicit" in of.method or "discrete" in of.method
    posed = case(of.scene)
    rate = euler_drifts(posed.problem, posed.scene.duration)["energy"]
    predicted = (-1.0 if implicit else 1.0) * rate * run.step
    return Record(
        scene=of.scene,
        method=of.method,
        step=run.step,  # [s]
        drift=run.invariants["energy"],
        predicted=predicted,
    )


def energy_claims(errors: Record) -> Claims:
    """The drifts are the predicted ones."""
    return (at_most("the drift's distance from the predicted one, relative,", errors.gap, ALIKE),)


def _runs(study: Study, methods: Sequence[str]) -> Iterator[tuple[ConvergenceStudy, Measurement]]:
    """Each convergence study, and its run nearest to a millisecond."""
    for scene in SHOWN:
        for method in methods:
            of = convergence_of(study, scene, method)
            run = reference_run(of.measurements, find_method(method)) if of else None
            if of and run:
                yield of, run


SECOND_ORDER = Analysis("free_body/second_order", second_order, claims=order_claims)
ENERGY = Analysis("free_body/energy", energy, claims=energy_claims)
SECTION = Section((SECOND_ORDER, ENERGY))
