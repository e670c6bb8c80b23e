"""The plots that every scene has: the motion, and the error over time, step and cost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Observables
from plumbob.models.scene import Observable
from plumbob.reports.advice.recommend import EXACT
from plumbob.reports.advice.work_precision import Point, front
from plumbob.reports.view import notation
from plumbob.reports.view.content import Figure, Layout, Trace
from plumbob.reports.view.palette import COLOURS, GREY, Style
from plumbob.reports.view.plotly_figure import (
    FRONT,
    curve,
    figure,
    linear,
    logarithmic,
    positive,
    rounded,
)
from plumbob.reports.view.records import Motion, PairVerdict
from plumbob.reports.view.tables import figures

SEEN = 0.01  # of a tolerance: smaller terms are drawn together
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
) -> tuple[Figure, ...]:
    """All figures of one scene, that of errors against cost first; what was not measured leaves its
    figure out."""
    stepped = [c for c in convergence if methods[c.method].control == "step"]
    traces = [(c.method, c.trace) for c in convergence if c.trace and any(c.trace.errors)]
    written = figures(
        "scene",
        leading=observables[0],
        symbol=symbol,
        styles=styles,
        motion=exact_motion(observables, motion),
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


def exact_motion(observables: Observables, motion: Motion) -> Figure:
    """The exact leading observable, and the second one on an axis of its own."""
    leading, *more = observables
    title = f"{symbol(leading.name)} [{leading.unit}]"
    first, *others = motion.channels
    traces = [curve(motion.times, first, colour="#0072b2", name=symbol(leading.name))]
    for second, values in zip(more[:1], others, strict=True):
        other = curve(motion.times, values, colour="#e69f00", dash="dash", name=symbol(second.name))
        traces.append({**other, "yaxis": "y2"})
    drawn = figure(
        "The exact motion",
        "What every method is compared with"
        + (f": the first {motion.periods} periods." if motion.periods else "."),
        traces,
        linear("time [s]"),
        linear(title),
        legend=True,
    )
    if more:
        side = linear(
            f"{symbol(more[0].name)} [{more[0].unit}]",
            overlaying="y",
            side="right",
            showgrid=False,
            tickmode="auto",
        )
        return Figure(drawn.title, drawn.caption, drawn.traces, {**drawn.layout, "yaxis2": side})
    return drawn


def error_against_cost(
    points: Sequence[Point],
    absolute: Mapping[tuple[str, float], str],
    methods: Mapping[str, Method],
    styles: Mapping[str, Style],
    limits: Mapping[str, float],
) -> Figure:
    """Relative error against speed, with the Pareto front; `absolute` are errors in SI units, as
    text, by method and step, `limits` the largest steps [s] before a method is lost. A closed form
    stands in the caption: it has no place on the axes."""
    usable = [p for p in points if np.isfinite(p.error) and p.ns_per_second]
    exact = [p for p in usable if methods[p.method].scheme.integrator == EXACT]
    simulated = [p for p in usable if p not in exact]
    best = front(simulated, lambda p: (p.ns_per_second, p.error))
    traces = [_edge(best)] if best else []
    for name in dict.fromkeys(p.method for p in simulated):
        line = [p for p in simulated if p.method == name]
        hints = [
            f"{notation.step(p.step, methods[name].control)}, "
            f"{notation.number(p.ns_per_second)} ns per simulated second"
            + (f", {text}" if (text := absolute.get((name, p.step))) else "")
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
    if exact:
        cost = min(p.ns_per_second for p in exact)
        text += (
            " Dotted: the speed of the closed form, whose error is round-off alone (real-time "
            f"factor {notation.real_time_factor(cost)}); it simulates nothing."
        )
    return figure(
        "Work–precision: relative error against speed",
        "Right and low is better. The grey band is the Pareto front: no other run is both faster "
        f"and more accurate. Costs are measured with nothing else running.{text}",
        [*traces, *ends],
        logarithmic("real-time factor: simulated time / computing time [1]"),
        logarithmic("relative error [1]"),
        height=460,
        wide=True,
        shapes=[_margin(max(_speed(p) for p in exact))] if exact else (),
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


def _margin(speed: float) -> Layout:
    """A line at the margin of a plot, at a real-time factor."""
    return {
        "type": "line",
        "xref": "x",
        "yref": "paper",
        "x0": speed,
        "x1": speed,
        "y0": 0.0,
        "y1": 0.12,
        "line": {"color": GREY, "width": 2, "dash": "dot"},
    }


def budget_bars(
    leading: Observable,
    convergence: Sequence[ConvergenceStudy],
    judged: Mapping[str, PairVerdict],
    methods: Mapping[str, Method],
    shown: Sequence[str],
) -> Figure | None:
    """The terms of the tolerance of one run of each of the `shown` methods, as stacked bars: of the
    allowed difference from the predicted error, or without a prediction, of the bound. None where
    none of them has a tolerance."""
    parts, bars = dict[str, dict[int, float]](), list[str]()
    for c in (c for c in convergence if c.method in shown):
        verdict = judged[c.method]
        held = next((b for b in verdict.budgets if b.observable == leading.name), None)
        if held is None:
            continue
        terms = held.tolerance.terms
        if held.predicted and len(terms) > 1:
            terms = terms[1:]
        if not (total := sum(term.value for term in terms)) > 0.0:
            continue
        at = notation.step(verdict.budget_step, methods[c.method].control)
        bars.append(f"{c.method}<br>{at}, ±{notation.number(total, 2)} {leading.unit}")
        for term in terms:
            named = (
                term.name.removeprefix("regularisation: ")
                if term.value >= SEEN * total
                else "others"
            )
            bar = parts.setdefault(named, {})
            bar[len(bars) - 1] = bar.get(len(bars) - 1, 0.0) + 100.0 * term.value / total
    if not parts:
        return None
    traces = tuple(
        {
            "type": "bar",
            "orientation": "h",
            "name": name,
            "x": rounded(list(of.values())),
            "y": list(of),
            "marker": {"color": COLOURS[k % len(COLOURS)]},
            "hovertemplate": f"{name}<br>%{{x:.3g}} % of the tolerance<extra></extra>",
        }
        for k, (name, of) in enumerate(parts.items())
    )
    layout, height = _bars_layout(bars, len(parts))
    return Figure(
        f"What the tolerance of {symbol(leading.name)} is made of",
        "One run of each method: by what its largest error may differ from the predicted one, or "
        "without a prediction, how large it may be. Reasons stand in the table of the budget.",
        traces,
        layout,
        height,
    )


def _bars_layout(bars: Sequence[str], terms: int) -> tuple[Layout, int]:
    """The layout of stacked bars with a legend of so many terms below, and its height [px]."""
    axis, legend = 50, 24 * terms  # [px]; a legend that moves margins may be laid out forever
    layout = {
        "barmode": "stack",
        "showlegend": True,
        "xaxis": {
            "title": {"text": "part of the tolerance [%]"},
            "range": [0, 100],
            "automargin": False,
        },
        "yaxis": {
            "title": {"text": ""},
            "automargin": False,
            "ticktext": bars,
            "tickvals": list(range(len(bars))),
            "zeroline": False,
        },
        "legend": {
            "orientation": "v",
            "xref": "container",
            "xanchor": "left",
            "yanchor": "top",
            "y": -axis / (44 * len(bars)),
            "maxheight": legend + 40,
        },
        "margin": {"l": 170, "t": 8, "b": axis + legend, "autoexpand": False},
    }
    return layout, 8 + 44 * len(bars) + axis + legend


def _done(convergence_study: ConvergenceStudy) -> list[Measurement]:
    return [m for m in convergence_study.measurements if m.status == "done"]
