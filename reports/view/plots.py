"""The figures of a scene's page: the motion, and the errors over time, step and cost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.method import Method
from plumbob.engines.study.convergence import Trace as ErrorTrace
from plumbob.engines.study.results import Observables
from plumbob.reports.advice.recommend import CLOSED_FORM_INTEGRATOR
from plumbob.reports.advice.work_precision import RunPoint, pareto_front
from plumbob.reports.records.page_records import MotionSamples
from plumbob.reports.view.content import Figure
from plumbob.reports.view.method_results import MethodResult, finite_limits
from plumbob.reports.view.palette import Style
from plumbob.reports.view.plotly_figure import ZERO
from plumbob.reports.view.tables import figures

# names of observables with their symbols in formulas
GREEK = (
    ("theta", "θ"),
    ("theta_dot", "dθ/dt"),
    ("psi", "ψ"),
    ("phi", "φ"),
)


def symbol(name: str) -> str:
    """Returns the name of an observable as a plot shows it."""
    return dict(GREEK).get(name, name.replace("_", " "))


def scene_figures(
    results: Sequence[MethodResult],
    observables: Observables,
    styles: Mapping[str, Style],
    motion: MotionSamples,
    points: Sequence[RunPoint],
    chosen: Sequence[str],
) -> tuple[Figure, ...]:
    """Returns the figures of a scene's page, the figure of errors against cost first. A figure
    without any measurement is left out.

    `results` are the results of all methods, `styles` their drawing styles, `points` their timed
    runs, and `chosen` the names of the methods whose Pareto front is drawn."""
    stepped = [result for result in results if result.method.control == "step"]
    limits = finite_limits(results)
    longest_bar = 2.0 * max(limits.values(), default=0.0)  # [s] for a method without a limit
    bars = [
        (result.name, result.accurate, min(result.limit.step, longest_bar))
        for result in results
        if limits and result.limit
    ]
    scene_plots = figures(
        "scene",
        leading=observables[0],
        symbol=symbol,
        styles=styles,
        motion=motion,
        channels=list(zip(observables, motion.channels, strict=False)),
        against_step=list(_errors_by_step(stepped, observables[0].name)),
        over_time=list(_errors_over_time(results)),
        drifts=_drifts(stepped),
        bars=bars,
    )
    methods = {result.name: result.method for result in results}
    work_precision = error_against_cost(points, methods, styles, limits, chosen)
    return tuple(figure for figure in (work_precision, *scene_plots) if figure.traces)


def _errors_over_time(
    results: Sequence[MethodResult],
) -> Iterator[tuple[MethodResult, ErrorTrace, Array]]:
    """Yields each result that has a trace of errors over time, that trace, and the magnitudes of
    its errors, at least `ZERO`; NaN for an error of zero, such as the error at the start."""
    for result in results:
        trace = result.series.trace
        if trace and any(trace.errors):
            magnitudes = np.abs(trace.errors)
            yield (
                result,
                trace,
                np.where(magnitudes > 0.0, np.maximum(magnitudes, ZERO), np.nan),
            )


def _errors_by_step(
    stepped: Sequence[MethodResult], leading: str
) -> Iterator[tuple[str, Mapping[float, float], Mapping[float, float]]]:
    """Yields, for each method, its name, the largest errors of the observable `leading` by step
    [s], and the predicted largest errors by step."""
    for result in stepped:
        errors = {run.step: run.errors[leading] for run in result.done if leading in run.errors}
        largest = {step: error.largest for step, error in errors.items()}
        predicted = {
            step: error.predicted.largest
            for step, error in errors.items()
            if error.predicted and error.predicted.nonlinearity < 1.0
        }
        if errors:
            yield result.name, largest, predicted


def _drifts(
    stepped: Sequence[MethodResult],
) -> Mapping[str, Mapping[str, Mapping[float, float]]]:
    """Returns the largest relative drift by invariant, method and step [s]."""
    drifts: dict[str, dict[str, dict[float, float]]] = {}
    for result in stepped:
        for run in result.done:
            for invariant, drift in run.invariants.items():
                by_method = drifts.setdefault(invariant, {})
                by_method.setdefault(result.name, {})[run.step] = drift
    return drifts


def error_against_cost(
    points: Sequence[RunPoint],
    methods: Mapping[str, Method],
    styles: Mapping[str, Style],
    limits: Mapping[str, float],
    chosen: Sequence[str],
) -> Figure:
    """Returns the figure of relative error against speed, with the Pareto front of the `chosen`
    methods, or of all methods if none of the chosen was timed.

    `limits` are the largest stable steps [s]. The figure marks the speed at such a step, at the
    error of the largest stable step that was run. A closed form simulates nothing and is left
    out."""
    lines: dict[str, list[RunPoint]] = {}
    for point in points:
        if (
            np.isfinite(point.error)
            and methods[point.method].scheme.integrator != CLOSED_FORM_INTEGRATOR
        ):
            lines.setdefault(point.method, []).append(point)
    ends = []
    for name, limit in limits.items():
        stable = [point for point in lines.get(name, ()) if point.step <= limit]
        if stable:
            last = max(stable, key=lambda point: point.step)
            ends.append((limit, last, last.speed * limit / last.step))
    drawn_points = [point for line in lines.values() for point in line]
    chosen_points = [point for point in drawn_points if point.method in chosen]
    (figure,) = figures(
        "work_precision",
        methods=methods,
        styles=styles,
        lines=lines,
        front=_pareto_front(drawn_points),
        band=_pareto_front(chosen_points or drawn_points),
        ends=ends,
    )
    return figure


def _pareto_front(points: Sequence[RunPoint]) -> Sequence[RunPoint]:
    """Returns the points that no other point beats in both speed and error."""
    return pareto_front(points, lambda point: (-point.speed, point.error))
