"""The tables of one scene: verdicts, orders, costs, every run, and the budget of a tolerance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import ConvergenceStudy, timed_run
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Observables
from plumbob.reports.view import notation
from plumbob.reports.view.content import Table
from plumbob.reports.view.records import PairVerdict
from plumbob.reports.view.tables import table, table_or_none

Series = Sequence[ConvergenceStudy]
Methods = Mapping[str, Method]
Verdicts = Mapping[str, PairVerdict]  # by method


def orders(convergence: Series, methods: Methods) -> Table | None:
    """Observed against predicted and declared order; None without a method that has one."""
    rows = [
        (
            c.method,
            methods[c.method].order,
            c.order and asdict(c.order),
            c.predicted_order if _within_reach(c) else None,
        )
        for c in convergence
        if methods[c.method].order is not None and _done(c)
    ]
    return table_or_none("orders", orders=rows)


def cost(convergence: Series, costs: Mapping[str, Cost], methods: Methods) -> Table | None:
    """Cost of a step, in ns and in reference step times; None where nothing was timed."""
    timed = []
    for c in convergence:
        if of := costs.get(c.method):
            at, ns, run = "", 0.0, timed_run(c, methods[c.method])
            if run and run.steps:
                at = notation.step(run.step, methods[c.method].control)
                ns = run.steps * of.ns_per_step / run.duration
            timed.append((c.method, of, at, ns))
    return table_or_none("cost", timed=timed)


def every_run(
    observables: Observables, convergence: Series, judged: Verdicts, methods: Methods
) -> Table:
    """Largest error of the leading observable of every run, with its verdict."""
    runs = {
        c.method: list(zip(c.measurements, judged[c.method].runs, strict=True)) for c in convergence
    }
    most = max(map(len, runs.values()), default=0)
    return table("every_run", leading=observables[0], runs=runs, most=most, methods=methods)


def budgets(
    observables: Observables, convergence: Series, judged: Verdicts, methods: Methods
) -> Table | None:
    """The tolerance of one run of each method, term by term: the first that fails, else the
    finest that is judged."""
    return table_or_none(
        "budgets",
        judged={c.method: judged[c.method] for c in convergence},
        units={o.name: o.unit for o in observables},
        methods=methods,
    )


def parameters(parameters: Mapping[str, Any], facts: Mapping[str, Any], source: str) -> Table:
    """A scene's parameters and what is exactly known of it, to the last digit."""
    return table("parameters", parameters=parameters, facts=facts, source=source)


def _done(convergence_study: ConvergenceStudy) -> list[Measurement]:
    return [m for m in convergence_study.measurements if m.status == "done"]


def _within_reach(convergence_study: ConvergenceStudy) -> bool:
    """Whether the errors that the order was fitted to are small enough for a series."""
    steps = convergence_study.order.steps if convergence_study.order else ()
    done = _done(convergence_study)
    predicted = [e.predicted for m in done if m.step in steps for e in m.errors.values()]
    return all(f is not None and f.nonlinearity < 1.0 for f in predicted)
