"""The figures of a scene's page: the motion, and the errors over time, step and cost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from plumbob.engines.method import Method
from plumbob.engines.study.results import Observables
from plumbob.reports.advice.recommend import EXACT
from plumbob.reports.advice.work_precision import Point, front
from plumbob.reports.view.content import Figure
from plumbob.reports.view.method_results import MethodResult, finite_limits
from plumbob.reports.view.palette import Style
from plumbob.reports.view.records import Motion
from plumbob.reports.view.tables import figures

GREEK = (
    ("theta", "θ"),
    ("theta_dot", "dθ/dt"),
    ("psi", "ψ"),
    ("phi", "φ"),
)  # names of observables with their symbols in formulas


def symbol(name: str) -> str:
    """Returns the name of an observable as a plot shows it."""
    return dict(GREEK).get(name, name.replace("_", " "))


def scene_figures(
    results: Sequence[MethodResult],
    observables: Observables,
    styles: Mapping[str, Style],
    motion: Motion,
    points: Sequence[Point],
    chosen: Sequence[str],
) -> tuple[Figure, ...]:
    """Returns the figures of a scene's page, the figure of errors against cost first. A figure
    without any measurement is left out.

    `results` are the results of all methods, `styles` their drawing styles, `points` their timed
    runs, and `chosen` the names of the methods whose Pareto front is drawn."""
    stepped = [of for of in results if of.method.control == "step"]
    limits = finite_limits(results)
    written = figures(
        "scene",
        leading=observables[0],
        symbol=symbol,
        styles=styles,
        motion=motion,
        channels=list(zip(observables, motion.channels, strict=False)),
        against_step=list(_errors(stepped, observables[0].name)),
        over_time=[
            (of, trace, np.where(np.abs(trace.errors) > 0.0, np.abs(trace.errors), np.nan))
            for of in results
            if (trace := of.series.trace) and any(trace.errors)
        ],
        drifts=_drifts(stepped),
        bars=[
            (of.name, of.accurate, min(of.limit.step, 2.0 * max(limits.values())))
            for of in results
            if limits and of.limit
        ],
    )
    methods = {of.name: of.method for of in results}
    speed = error_against_cost(points, methods, styles, limits, chosen)
    return tuple(f for f in (speed, *written) if f.traces)


def _errors(
    stepped: Sequence[MethodResult], leading: str
) -> Iterator[tuple[str, Mapping[float, float], Mapping[float, float]]]:
    """Yields, for each method, its name, the largest errors of the observable `leading` by step
    [s], and the predicted largest errors by step."""
    for of in stepped:
        errors = {m.step: m.errors[leading] for m in of.done if leading in m.errors}
        predicted = {
            step: e.predicted.largest
            for step, e in errors.items()
            if e.predicted and e.predicted.nonlinearity < 1.0
        }
        if errors:
            yield of.name, {step: e.largest for step, e in errors.items()}, predicted


def _drifts(
    stepped: Sequence[MethodResult],
) -> Mapping[str, Mapping[str, Mapping[float, float]]]:
    """Returns the largest relative drift by invariant, method and step [s]."""
    rows: dict[str, dict[str, dict[float, float]]] = {}
    for of in stepped:
        for m in of.done:
            for name, drift in m.invariants.items():
                rows.setdefault(name, {}).setdefault(of.name, {})[m.step] = drift
    return rows


def error_against_cost(
    points: Sequence[Point],
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
    lines: dict[str, list[Point]] = {}
    for p in points:
        if np.isfinite(p.error) and methods[p.method].scheme.integrator != EXACT:
            lines.setdefault(p.method, []).append(p)
    ends = []
    for name, limit in limits.items():
        if stable := [p for p in lines.get(name, ()) if p.step <= limit]:
            last = max(stable, key=lambda p: p.step)
            ends.append((limit, last, last.speed * limit / last.step))
    every = [p for of in lines.values() for p in of]
    band = [p for p in every if p.method in chosen] or every
    best, shown = (front(of, lambda p: (-p.speed, p.error)) for of in (every, band))
    (drawn,) = figures(
        "work_precision",
        methods=methods,
        styles=styles,
        lines=lines,
        front=best,
        band=shown,
        ends=ends,
    )
    return drawn
