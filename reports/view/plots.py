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
from plumbob.reports.view.content import Figure
from plumbob.reports.view.palette import Style
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
    """Relative error against speed, with the Pareto front; `limits` are the largest steps [s]
    before a method is lost: its speed there is marked at the error of its largest step that is
    stable. A closed form, which simulates nothing, is left out."""
    lines: dict[str, list[Point]] = {}
    for p in points:
        if np.isfinite(p.error) and methods[p.method].scheme.integrator != EXACT:
            lines.setdefault(p.method, []).append(p)
    stable = {n: [p for p in lines.get(n, ()) if p.step <= limit] for n, limit in limits.items()}
    last = {name: max(of, key=lambda p: p.step) for name, of in stable.items() if of}
    (drawn,) = figures(
        "work_precision",
        methods=methods,
        styles=styles,
        lines=lines,
        front=front((p for of in lines.values() for p in of), lambda p: (-p.speed, p.error)),
        ends=[(limits[name], p, p.speed * limits[name] / p.step) for name, p in last.items()],
    )
    return drawn


def _done(convergence_study: ConvergenceStudy) -> list[Measurement]:
    return [m for m in convergence_study.measurements if m.status == "done"]
