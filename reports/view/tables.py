"""The tables of one scene: verdicts, orders, costs, every run, and the budget of a tolerance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import ConvergenceStudy, timed_run
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.order import Order
from plumbob.engines.study.results import Observables
from plumbob.models.scene import Observable, Scene
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Table, row
from plumbob.reports.view.records import Budget, PairVerdict, RunVerdict

Costs = Mapping[str, Cost]  # by method


def verdict_cell(judged: PairVerdict, link: str = "") -> Cell:
    """A verdict, coloured, and marked as known limit or as unexpected."""
    text, hint = (
        judged.verdict.replace("-", " "),
        judged.reason or "as predicted, or within its bound",
    )
    if judged.mark:
        text += f" ({judged.mark})"
        hint += f"; expected {judged.expected}"
        hint += f": {judged.declared}" if judged.declared else ""
    kind = f"{judged.verdict} surprise" if judged.mark == "unexpected" else judged.verdict
    return Cell(text, kind, hint, link)


def summary(
    observables: Observables,
    convergence: Sequence[ConvergenceStudy],
    judged: Mapping[str, PairVerdict],
    methods: Mapping[str, Method],
) -> Table:
    """Verdict of each method, and its errors and drift at the finest step."""
    invariants = dict.fromkeys(n for c in convergence for m in c.measurements for n in m.invariants)
    rows = []
    for c in convergence:
        verdict = verdict_cell(judged[c.method])
        finest = next((m for m in reversed(c.measurements) if m.status == "done"), None)
        reason = Cell(judged[c.method].reason, "reason")
        if finest is None:
            blank = [""] * (1 + len(observables) + len(invariants))
            rows.append(row(Cell(c.method, "method"), verdict, *blank, reason))
            continue
        errors = [
            _number(finest.errors[o.name].largest) if o.name in finest.errors else ""
            for o in observables
        ]
        kept = [_number(finest.invariants[n]) if n in finest.invariants else "" for n in invariants]
        at = Cell(notation.step(finest.step, methods[c.method].control), "number")
        rows.append(row(Cell(c.method, "method"), verdict, at, *errors, *kept, reason))
    heads = (
        "method",
        "verdict",
        "finest step",
        *(f"error of {o.name} [{o.unit}]" for o in observables),
        *(f"drift of {n}" for n in invariants),
        "reason",
    )
    note = "Errors are the largest over the run, drifts relative."
    return Table("Verdicts, and the finest step of each method", heads, tuple(rows), note)


def orders(convergence: Sequence[ConvergenceStudy], methods: Mapping[str, Method]) -> Table | None:
    """Observed against predicted and declared order; None without a method that has one."""
    rows = []
    for c in convergence:
        method = methods[c.method]
        done = [m for m in c.measurements if m.status == "done"]
        if method.order is None or not done:
            continue
        between = ""
        if c.order is not None:
            steps = c.order.steps
            between = (
                f"{len(steps)} steps, {notation.short(steps[0])} to {notation.short(steps[-1])} s"
            )
        rows.append(
            row(
                Cell(c.method, "method"),
                Cell(str(method.order), "number"),
                _order(c.order, interval=True),
                _order(c.predicted_order if _within_reach(c, done) else None, interval=False),
                between or "fewer than four steps above the round-off level",
            )
        )
    if not rows:
        return None
    note = (
        "The order depends on the observable and the motion, not only on the method: predicted is "
        "the slope of the predicted error of this observable at the same steps, where the steps "
        "are in the range of the theory."
    )
    heads = ("method", "nominal", "observed [95 % interval]", "predicted here", "fitted to")
    return Table("Order of convergence", heads, tuple(rows), note)


def cost(
    convergence: Sequence[ConvergenceStudy], costs: Costs, methods: Mapping[str, Method]
) -> Table | None:
    """Cost of a step, in ns and in reference step times; None where nothing was timed."""
    rows = []
    for c in convergence:
        if (cost_of := costs.get(c.method)) is None:
            continue
        speed, m = "", timed_run(c, methods[c.method])
        if m is not None and m.steps:
            factor = notation.real_time_factor(m.steps * cost_of.ns_per_step / m.duration)
            speed = f"{factor} at {notation.step(m.step, methods[c.method].control)}"
        scatter = f"{notation.number(cost_of.low)} – {notation.number(cost_of.high)}"
        rows.append(
            row(
                Cell(c.method, "method"),
                Cell(notation.number(cost_of.ns_per_step), "number"),
                Cell(scatter, "number"),
                Cell(notation.number(cost_of.ratio), "number"),
                Cell(notation.seconds(cost_of.compile_seconds), "number"),
                Cell(speed, "number"),
            )
        )
    if not rows:
        return None
    heads = (
        "method",
        "ns per step",
        "quartiles",
        "reference step times",
        "compile time",
        "real-time factor",
    )
    note = (
        "Medians of interleaved repeats, with nothing else running, each over the time of "
        "reference steps just before and after it. A step of an adaptive solver is one evaluation "
        "of the equation. The reference step is a bare MuJoCo step of an empty model. Real-time "
        "factor: simulated time over wall time."
    )
    return Table("Cost", heads, tuple(rows), note)


def every_run(
    observables: Observables,
    convergence: Sequence[ConvergenceStudy],
    judged: Mapping[str, PairVerdict],
    methods: Mapping[str, Method],
) -> Table:
    """Largest error of the leading observable of every run, with its verdict."""
    leading = observables[0]
    most = max((len(c.measurements) for c in convergence), default=0)
    rows = []
    for c in convergence:
        cells = [
            _run(m, j, methods[c.method], leading)
            for m, j in zip(c.measurements, judged[c.method].runs, strict=True)
        ]
        rows.append(row(Cell(c.method, "method"), *cells, *[""] * (most - len(cells))))
    heads = ("method", *(f"step {i + 1}" for i in range(most)))
    note = "Coarse to fine. Colour: the verdict on the run; hover for step, tolerance and reason."
    caption = f"Every run: largest error of {leading.name} [{leading.unit}]"
    return Table(caption, heads, tuple(rows), note, folded=True)


def budgets(
    observables: Observables,
    convergence: Sequence[ConvergenceStudy],
    judged: Mapping[str, PairVerdict],
    methods: Mapping[str, Method],
) -> Table | None:
    """The tolerance of one run of each method, term by term: the first that fails, else the
    finest that is judged."""
    units, rows = {o.name: o.unit for o in observables}, []
    for c in convergence:
        verdict, name = judged[c.method], Cell(c.method, "method")
        if not verdict.budgets and not verdict.unjudged:
            continue
        at = Cell(notation.step(verdict.budget_step, methods[c.method].control), "number")
        for held in verdict.budgets:
            head = (
                f"{held.observable}, error {notation.number(held.error)} {units[held.observable]}"
            )
            total = Cell(notation.number(held.tolerance.bound), "number total")
            rows.append(row(name, at, head, total, "", Cell(_within(held), "total")))
            for term in held.tolerance.terms:
                value = Cell(notation.number(term.value), "number")
                rows.append(row("", "", "", value, term.name, Cell(term.reason, "reason")))
        for unjudged, why in verdict.unjudged.items():
            rows.append(row(name, "", unjudged, "", "not judged", Cell(why, "reason")))
    if not rows:
        return None
    heads = ("method", "step", "observable", "bound", "term", "reason")
    note = (
        "One run of each method: the first that fails, with every observable, else the finest, "
        "with the first one. The sum is the most that the error may be; where it is predicted, "
        "it may differ from the prediction by the other terms alone, to either side. An observable "
        "that is judged in no run says why."
    )
    return Table("Tolerance budget, term by term", heads, tuple(rows), note, folded=True)


def _within(held: Budget) -> str:
    if not held.exceeded:
        return "the sum: within"
    larger = held.error > held.tolerance.bound
    return "the sum: EXCEEDED" if larger else f"the sum: within, but EXCEEDED: {held.exceeded}"


def parameters(scene: Scene, facts: Mapping[str, Any]) -> Table:
    """The scene's parameters and what is exactly known of it, to the last digit."""
    known = {name.replace("_", " "): value for name, value in facts.items()}
    rows = [
        row(name, Cell(_plain(value), "number"))
        for name, value in (*scene.parameters.items(), *known.items())
    ]
    caption = "Parameters (SI), and what is exactly known"
    return Table(caption, ("name", "value"), tuple(rows), scene.source, folded=True)


def _plain(value: object) -> str:
    return f"{value:.17g}" if isinstance(value, float) else str(value)


def _run(run: Measurement, judged: RunVerdict, method: Method, leading: Observable) -> Cell:
    at = notation.step(run.step, method.control)
    if run.status != "done":
        return Cell(run.status, judged.verdict, f"{at}: {run.reason}")
    hint = f"{at}: {judged.reason or judged.verdict}"
    if leading.name not in run.errors:
        return Cell("–", f"{judged.verdict} number", hint)
    error = run.errors[leading.name]
    if judged.bound is not None:
        allowed, what = judged.bound, "allowed"
        if (predicted := error.predicted) is not None and error.left_open is not None:
            allowed = error.left_open
            what = f"{notation.number(predicted.difference)} off its prediction, allowed"
        hint += f"; {what} {notation.number(allowed)} {leading.unit}"
    return Cell(notation.number(error.largest), f"{judged.verdict} number", hint)


def _within_reach(convergence_study: ConvergenceStudy, done: Sequence[Measurement]) -> bool:
    """Whether the errors that the order was fitted to are small enough for a series."""
    steps = convergence_study.order.steps if convergence_study.order else ()
    predicted = [e.predicted for m in done if m.step in steps for e in m.errors.values()]
    return all(f is not None and f.nonlinearity < 1.0 for f in predicted)


def _order(order: Order | None, interval: bool) -> Cell:
    if order is None:
        return Cell("–", "number")
    text = f"{order.slope:.3f}"
    return Cell(f"{text} [{order.low:.3f}, {order.high:.3f}]" if interval else text, "number")


def _number(value: float) -> Cell:
    return Cell(notation.number(value), "number")
