"""The plots that every scene has: the motion, and the error over time, step and cost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from plumbob.engines.method import Method
from plumbob.engines.study.results import Observables
from plumbob.reports.advice.recommend import CLOSED_FORM
from plumbob.reports.advice.work_precision import Point, pareto_front
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
)  # as formulas have them


def symbol(name: str) -> str:
    """An observable's name as a plot shows it."""
    return dict(GREEK).get(name, name.replace("_", " "))


def scene_figures(
    results: Sequence[MethodResult],
    observables: Observables,
    styles: Mapping[str, Style],
    motion: Motion,
    points: Sequence[Point],
    chosen: Sequence[str],
) -> tuple[Figure, ...]:
    """All figures of one scene by the results of its methods, of which the `chosen` ones are drawn
    first, that of errors against cost before others; what was not measured leaves its figure out.
    """
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
    """Of each method the largest errors by step [s], and those predicted."""
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
    """By invariant and method the largest relative drifts by step [s]."""
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
    """Relative error against speed, with the Pareto front of the `chosen` methods, or of all where
    none of these was timed; `limits` are the largest steps [s] before a method is lost: its speed
    there is marked at the error of its largest step that is stable. A closed form, which simulates
    nothing, is left out."""
    lines: dict[str, list[Point]] = {}
    for p in points:
        if np.isfinite(p.error) and methods[p.method].scheme.integrator != CLOSED_FORM:
            lines.setdefault(p.method, []).append(p)
    ends = []
    for name, limit in limits.items():
        if stable := [p for p in lines.get(name, ()) if p.step <= limit]:
            last = max(stable, key=lambda p: p.step)
            ends.append((limit, last, last.speed * limit / last.step))
    every = [p for of in lines.values() for p in of]
    band = [p for p in every if p.method in chosen] or every
    best, shown = (pareto_front(of, lambda p: (-p.speed, p.error)) for of in (every, band))
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
