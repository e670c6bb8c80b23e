"""The page's section on the free body: why MuJoCo's RK4 is of second order on it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement, reference_run, worst
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record, Section
from plumbob.reports.analyses.claims import Claims, as_predicted, between
from plumbob.reports.analyses.measurements import convergence_of

RK4: Final = ("mujoco/rk4", "ode/rk4")
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


def _runs(study: Study, methods: Sequence[str]) -> Iterator[tuple[ConvergenceStudy, Measurement]]:
    """Each convergence study, and its run nearest to a millisecond."""
    for scene in SHOWN:
        for method in methods:
            of = convergence_of(study, scene, method)
            run = reference_run(of.measurements, find_method(method)) if of else None
            if of and run:
                yield of, run


SECOND_ORDER = Analysis("free_body/second_order", second_order, claims=order_claims)
SECTION = Section((SECOND_ORDER,))
