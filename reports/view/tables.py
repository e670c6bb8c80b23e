"""The tables of one scene: verdicts, orders, costs, every run, and the budget of a tolerance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import ConvergenceStudy, timed_run
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.order import Order
from plumbob.models.registry import case_of
from plumbob.models.scene import Scene, System
from plumbob.reports.judge.expectations import expected, marked
from plumbob.reports.judge.tolerance import Tolerance, exceeded
from plumbob.reports.judge.verdict import Judged, Judgement
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Table, row

Costs = Mapping[str, Cost]  # by method
BAD = ("fail", "not-converging", "diverged", "cut-short")


def verdict_cell(scene: str, method: str, judged: Judgement, link: str = "") -> Cell:
    """A verdict, coloured, and marked as known limit or as unexpected."""
    wanted = expected(scene, method)
    text, hint = (
        judged.verdict.replace("-", " "),
        judged.reason or "as predicted, or within its bound",
    )
    if mark := marked(scene, method, judged):
        text += f" ({mark})"
        hint += f"; expected {wanted.verdict}"
        hint += f": {wanted.reason}" if wanted.reason else ""
    kind = f"{judged.verdict} surprise" if mark == "unexpected" else judged.verdict
    return Cell(text, kind, hint, link)


def summary(
    system: System,
    convergence: Sequence[ConvergenceStudy],
    judged: Mapping[str, Judged],
    methods: Mapping[str, Method],
) -> Table:
    """Verdict of each method, and its errors and drift at the finest step."""
    invariants = dict.fromkeys(n for c in convergence for m in c.measurements for n in m.invariants)
    rows = []
    for c in convergence:
        verdict = verdict_cell(c.scene, c.method, judged[c.method].whole)
        finest = next((m for m in reversed(c.measurements) if m.status == "done"), None)
        reason = Cell(judged[c.method].whole.reason, "reason")
        if finest is None:
            blank = [""] * (1 + len(system.observables) + len(invariants))
            rows.append(row(Cell(c.method, "method"), verdict, *blank, reason))
            continue
        errors = [
            _number(finest.errors[o.name].largest) if o.name in finest.errors else ""
            for o in system.observables
        ]
        kept = [_number(finest.invariants[n]) if n in finest.invariants else "" for n in invariants]
        at = Cell(notation.step(finest.step, methods[c.method].control), "number")
        rows.append(row(Cell(c.method, "method"), verdict, at, *errors, *kept, reason))
    heads = (
        "method",
        "verdict",
        "finest step",
        *(f"error of {o.name} [{o.unit}]" for o in system.observables),
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
    system: System,
    convergence: Sequence[ConvergenceStudy],
    judged: Mapping[str, Judged],
    methods: Mapping[str, Method],
) -> Table:
    """Largest error of the leading observable of every run, with its verdict."""
    leading = system.observables[0]
    most = max((len(c.measurements) for c in convergence), default=0)
    rows = []
    for c in convergence:
        cells = [
            _run(m, j, methods[c.method], leading.name)
            for m, j in zip(c.measurements, judged[c.method].runs, strict=True)
        ]
        rows.append(row(Cell(c.method, "method"), *cells, *[""] * (most - len(cells))))
    heads = ("method", *(f"step {i + 1}" for i in range(most)))
    note = "Coarse to fine. Colour: the verdict on the run; hover for step, tolerance and reason."
    caption = f"Every run: largest error of {leading.name} [{leading.unit}]"
    return Table(caption, heads, tuple(rows), note, folded=True)


def budgets(
    system: System,
    convergence: Sequence[ConvergenceStudy],
    judged: Mapping[str, Judged],
    methods: Mapping[str, Method],
) -> Table | None:
    """The tolerance of one run of each method, term by term: the first that fails, else the
    finest that is judged."""
    rows = []
    for c in convergence:
        if (held := budgeted(c, judged[c.method])) is None:
            continue
        m, j = held
        shown = [system.observables[0].name] if j.verdict != "fail" else list(j.tolerances)
        for name, bound in ((n, b) for n, b in j.tolerances.items() if n in shown):
            error = m.errors[name].largest
            head = f"{name}, error {notation.number(error)} {bound.unit}"
            total = Cell(notation.number(bound.bound), "number total")
            verdict = Cell(_within(system, m, name, bound), "total")
            at = Cell(notation.step(m.step, methods[c.method].control), "number")
            rows.append(row(Cell(c.method, "method"), at, head, total, "", verdict))
            for term in bound.terms:
                value = Cell(notation.number(term.value), "number")
                rows.append(row("", "", "", value, term.name, Cell(term.reason, "reason")))
        for name, why in judged[c.method].whole.unjudged.items():
            cells = ("", name, "", "not judged", Cell(why, "reason"))
            rows.append(row(Cell(c.method, "method"), *cells))
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


def budgeted(series: ConvergenceStudy, judged: Judged) -> tuple[Measurement, Judgement] | None:
    """The run whose tolerance is shown: the first that fails, else the finest that is judged; None
    where no run has a tolerance."""
    held = [(m, j) for m, j in zip(series.measurements, judged.runs, strict=True) if j.tolerances]
    if not held:
        return None
    return next((pair for pair in held if pair[1].verdict == "fail"), held[-1])


def _within(system: System, run: Measurement, name: str, bound: Tolerance) -> str:
    units = {o.name: o.unit for o in system.observables}
    if (why := exceeded(run, name, bound, units)) is None:
        return "the sum: within"
    larger = run.errors[name].largest > bound.bound
    return "the sum: EXCEEDED" if larger else f"the sum: within, but EXCEEDED: {why}"


def parameters(system: System, scene: Scene) -> Table:
    """The scene's parameters and what is exactly known of it, to the last digit."""
    rows = [row(name, Cell(_plain(value), "number")) for name, value in scene.parameters.items()]
    rows += [
        row(name.replace("_", " "), Cell(_plain(value), "number"))
        for name, value in system.facts(case_of(scene).problem).items()
        if isinstance(value, (int, float, str)) and value != ""
    ]
    caption = "Parameters (SI), and what is exactly known"
    return Table(caption, ("name", "value"), tuple(rows), scene.source, folded=True)


def _plain(value: object) -> str:
    return f"{value:.17g}" if isinstance(value, float) else str(value)


def _run(run: Measurement, judged: Judgement, method: Method, leading: str) -> Cell:
    at = notation.step(run.step, method.control)
    if run.status != "done":
        return Cell(run.status, judged.verdict, f"{at}: {run.reason}")
    hint = f"{at}: {judged.reason or judged.verdict}"
    if leading not in run.errors:
        return Cell("–", f"{judged.verdict} number", hint)
    error = run.errors[leading]
    if bound := judged.tolerances.get(leading):
        allowed, what = bound.bound, "allowed"
        if (predicted := error.predicted) is not None and error.left_open is not None:
            allowed = error.left_open
            what = f"{notation.number(predicted.difference)} off its prediction, allowed"
        hint += f"; {what} {notation.number(allowed)} {bound.unit}"
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
