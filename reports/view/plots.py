"""The plots that every scene has: the motion, and the error over time, step and cost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Observables
from plumbob.reports.advice.recommend import EXACT
from plumbob.reports.advice.work_precision import Point, front
from plumbob.reports.view import notation
from plumbob.reports.view.content import Figure, Trace
from plumbob.reports.view.palette import GREY, Style
from plumbob.reports.view.plotly_figure import (
    FRONT,
    curve,
    figure,
    logarithmic,
    positive,
)
from plumbob.reports.view.records import Motion
from plumbob.reports.view.step_ranges import StepRange, finite_limits
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
    observables: Observables,
    convergence: Sequence[ConvergenceStudy],
    methods: Mapping[str, Method],
    styles: Mapping[str, Style],
    motion: Motion,
    against_cost: Figure,
    ranges: Sequence[StepRange] = (),
) -> tuple[Figure, ...]:
    """All figures of one scene, that of errors against cost first; what was not measured leaves its
    figure out."""
    stepped = [c for c in convergence if methods[c.method].control == "step"]
    limits = finite_limits(ranges).values()
    traces = [(c.method, c.trace) for c in convergence if c.trace and any(c.trace.errors)]
    written = figures(
        "scene",
        leading=observables[0],
        symbol=symbol,
        styles=styles,
        motion=motion,
        channels=list(zip(observables, motion.channels, strict=False)),
        against_step=list(_errors(stepped, observables[0].name)),
        over_time=[
            (
                name,
                notation.step(of.step, methods[name].control),
                of.times,
                np.where(np.abs(of.errors) > 0.0, np.abs(of.errors), np.nan),
            )
            for name, of in traces
        ],
        drifts=_drifts(stepped),
        bars=[
            (of.method, of.accurate, min(of.limit.step, 2.0 * max(limits)))
            for of in ranges
            if limits and of.limit
        ],
    )
    return tuple(f for f in (against_cost, *written) if f.traces)


def _errors(
    stepped: Sequence[ConvergenceStudy], leading: str
) -> Iterator[tuple[str, Sequence[float], Sequence[float], Mapping[float, float]]]:
    """Of each method its steps [s], the largest errors at them, and those predicted by step."""
    for c in stepped:
        errors = {m.step: m.errors[leading] for m in _done(c) if leading in m.errors}
        predicted = {
            step: e.predicted.largest
            for step, e in errors.items()
            if e.predicted and e.predicted.nonlinearity < 1.0
        }
        if errors:
            yield c.method, list(errors), [e.largest for e in errors.values()], predicted


def _drifts(
    stepped: Sequence[ConvergenceStudy],
) -> Mapping[str, Sequence[tuple[str, Sequence[float], Sequence[float]]]]:
    """By invariant, of each method its steps [s] and the largest relative drifts at them."""
    rows: dict[str, list[tuple[str, Sequence[float], Sequence[float]]]] = {}
    for name in dict.fromkeys(name for c in stepped for m in _done(c) for name in m.invariants):
        for c in stepped:
            drifts = {m.step: m.invariants[name] for m in _done(c) if name in m.invariants}
            if drifts:
                rows.setdefault(name, []).append((c.method, list(drifts), list(drifts.values())))
    return rows


def error_against_cost(
    points: Sequence[Point],
    methods: Mapping[str, Method],
    styles: Mapping[str, Style],
    limits: Mapping[str, float],
) -> Figure:
    """Relative error against speed, with the Pareto front; `limits` are the
    largest steps [s] before a method is lost. A closed form,
    which simulates nothing, is left out."""
    simulated = [
        p
        for p in points
        if np.isfinite(p.error) and p.ns_per_second and methods[p.method].scheme.integrator != EXACT
    ]
    best = front(simulated, lambda p: (p.ns_per_second, p.error))
    traces = [_edge(best)] if best else []
    for name in dict.fromkeys(p.method for p in simulated):
        line = [p for p in simulated if p.method == name]
        hints = [
            f"{notation.step(p.step, methods[name].control)}, "
            f"{notation.number(p.ns_per_second)} ns per simulated second"
            + (", on the Pareto front" if p in best else "")
            for p in line
        ]
        hint = f"{name}<br>%{{text}}<br>relative error %{{y:.3g}}<br>real-time factor %{{x:.3g}}"
        traces.append(
            curve(
                [_speed(p) for p in line],
                positive([p.error for p in line]),
                styles[name],
                method=name,
                marks=True,
                width=1.2,
                hints=hints,
                hint=hint,
            )
        )
    ends = list(_ends(simulated, limits, styles))
    text = " A cross marks where a method is lost: the speed at its largest step." if ends else ""
    return figure(
        "Work–precision: relative error against speed",
        "Right and low is better. The grey band is the Pareto front: no other run is both faster "
        f"and more accurate. Costs are measured with nothing else running.{text}",
        [*traces, *ends],
        logarithmic("real-time factor: simulated time / computing time [1]"),
        logarithmic("relative error [1]"),
        height=460,
        wide=True,
    )


def _ends(
    simulated: Sequence[Point], limits: Mapping[str, float], styles: Mapping[str, Style]
) -> Iterator[Trace]:
    """From the largest step of each method that is stable, a dotted line to the speed at its limit;
    at the error of that run, since there is none at the limit."""
    for name, limit in limits.items():
        stable = [p for p in simulated if p.method == name and p.step <= limit]
        if not stable:
            continue
        last = max(stable, key=lambda p: p.step)
        error, speeds = positive([last.error]), (_speed(last), _speed(last) * limit / last.step)
        hint = f"{name}<br>lost at steps above {notation.number(limit, 3)} s"
        line = curve(speeds, np.repeat(error, 2), styles[name], method=name, dash="dot")
        cross = curve(speeds[1:], error, styles[name], method=name, marks=True, hint=hint)
        marker = {"color": styles[name].colour, "size": 9, "symbol": "x"}
        yield {**line, "showlegend": False, "hoverinfo": "skip"}
        yield {**cross, "mode": "markers", "marker": marker, "showlegend": False}


def _edge(best: Sequence[Point]) -> Trace:
    """The Pareto front, as a broad band."""
    speeds, errors = [_speed(p) for p in best], positive([p.error for p in best])
    edge = curve(speeds, errors, colour=GREY, dash="solid", width=7.0, name="Pareto front")
    return {**edge, "opacity": 0.35, "hoverinfo": "skip", "meta": FRONT}


def _speed(point: Point) -> float:
    """The real-time factor of a run."""
    return 1e9 / point.ns_per_second


def _done(convergence_study: ConvergenceStudy) -> list[Measurement]:
    return [m for m in convergence_study.measurements if m.status == "done"]
