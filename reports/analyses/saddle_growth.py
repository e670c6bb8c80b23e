"""How errors grow next to a saddle of the potential, whatever their cause."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.convergence import Trace as ErrorsOverTime
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Figure, Table, method_cell, row
from plumbob.reports.view.palette import GREY, styles
from plumbob.reports.view.traces import Trace, curve, logarithmic, over_time, positive

NEAR = 0.25  # [rad] from the saddle, where the motion is linear in the distance to 3 %
LINEAR = 0.1  # [rad]: an error larger than this no longer grows as e^(lambda t)
FEW = 4  # samples that a rate is not fitted to


@dataclass(frozen=True)
class Saddle:
    """An angle [rad] where a pendulum may stand, and the rate [1/s] at which it departs from it."""

    theta: float
    rate: float


@dataclass(frozen=True)
class MethodGrowth:
    """Errors of a method's run [rad] over time [s], from the second sample on."""

    method: str
    times: tuple[float, ...]
    errors: tuple[float, ...]
    rate: float | None  # [1/s], fitted next to the saddle; None with too few samples
    small_until: float | None  # [s]: the first larger than LINEAR


@dataclass(frozen=True)
class SaddleGrowth:
    """How errors grow while the exact motion is next to a saddle, the first time."""

    rate: float  # [1/s], at which a motion departs from it
    start: float  # [s], of the stay
    end: float
    runs: tuple[MethodGrowth, ...]
    methods: tuple[str, ...]  # of the study
    times: Array  # [s]
    rounding: Array  # [rad], the effect of one rounding of each input, at them
    stay: Array  # times [s] of the stay
    growth: Array  # [rad], exponential, at them
    near: float = NEAR
    linear: float = LINEAR


def growth_at_saddle(
    study: Study, scene: Scene, motion: PendulumMotion, saddle: Saddle
) -> SaddleGrowth | None:
    """Errors of the study's runs of a scene over time, and the rates they grow at while its exact
    `motion` is next to the saddle; None where it never is."""
    traces = {
        c.method: c.trace
        for c in study.convergence
        if c.scene == scene.name and c.trace and any(c.trace.errors)
    }
    within = _first_stay(motion, saddle, np.linspace(0.0, scene.duration, 2001))
    if within is None or not traces:
        return None
    start, end = within
    times, stay = np.linspace(0.0, scene.duration, 200)[1:], np.linspace(start, end, 20)
    rounding = motion.uncertainty(times)["theta"]
    growth = np.interp(start, times, rounding) * np.exp(saddle.rate * (stay - start))
    return SaddleGrowth(
        saddle.rate,
        start,
        end,
        tuple(_grown(method, trace, start, end) for method, trace in traces.items()),
        tuple(method.name for method in study.methods),
        times,
        rounding,
        stay,
        growth,
    )


def _grown(method: str, trace: ErrorsOverTime, start: float, end: float) -> MethodGrowth:
    """A run with its rate, fitted over the second half of the stay from `start` to `end`, where the
    growing mode dominates, while the error is small."""
    times, errors = np.array(trace.times), np.abs(trace.errors)
    large = times[errors >= LINEAR]
    until = min(end, float(large[0])) if large.size else end
    small = (errors < LINEAR) & (errors > 0.0)
    used = small & (times >= (start + until) / 2) & (times < until)
    slope = np.polyfit(times[used], np.log(errors[used]), 1)[0] if used.sum() > FEW else None
    lost = float(large[0]) if large.size else None
    return MethodGrowth(method, trace.times[1:], trace.errors[1:], slope, lost)


def saddle_growth(
    study: Study, scene: Scene, motion: PendulumMotion, saddle: Saddle, note: str = ""
) -> tuple[Figure | Table, ...]:
    """Errors of the study's runs of a scene over time, and the rates they grow at while its exact
    `motion` is next to the saddle; nothing where it never is."""
    convergence = [
        c for c in study.convergence if c.scene == scene.name and c.trace and any(c.trace.errors)
    ]
    stay = _first_stay(motion, saddle, np.linspace(0.0, scene.duration, 2001))
    if stay is None or not convergence:
        return ()
    plot = _growth(motion, saddle, stay, convergence, study, scene)
    table = _rates(saddle, stay, convergence, note)
    return (plot, table) if table else (plot,)


def _first_stay(motion: PendulumMotion, saddle: Saddle, times: Array) -> tuple[float, float] | None:
    """When the exact motion first comes within NEAR of the saddle, and when it leaves."""
    theta = motion.state(times)[0]
    distance = np.abs((theta - saddle.theta + np.pi) % (2 * np.pi) - np.pi)
    inside = np.flatnonzero(distance < NEAR)
    if not inside.size:
        return None
    ends = np.flatnonzero(np.diff(inside) > 1)
    last = inside[ends[0]] if ends.size else inside[-1]
    return float(times[inside[0]]), float(times[last])


def _growth(
    motion: PendulumMotion,
    saddle: Saddle,
    stay: tuple[float, float],
    convergence: Sequence[ConvergenceStudy],
    study: Study,
    scene: Scene,
) -> Figure:
    """Errors over time against e^(lambda t), with the effect of rounding the inputs."""
    style = styles(study.methods)
    traces: list[Trace] = [
        {
            **curve(
                c.trace.times[1:], positive(c.trace.errors[1:]), style[c.method], method=c.method
            ),
            "showlegend": False,
        }
        for c in convergence
        if c.trace is not None
    ]
    times = np.linspace(0.0, scene.duration, 200)[1:]
    doubt = motion.uncertainty(times)["theta"]
    traces.append(
        curve(times, positive(doubt), colour=GREY, dash="dot", width=2.0,
              name="one rounding of each input")
    )  # fmt: skip
    start, end = stay
    dwell = np.linspace(start, end, 20)
    foot = float(np.interp(start, times, doubt))
    traces.append(
        curve(dwell, foot * np.exp(saddle.rate * (dwell - start)), colour=GREY, dash="dash",
              width=3.0, name=f"e^(λt), λ = {saddle.rate:.3f}/s")
    )  # fmt: skip
    return over_time(
        "How errors grow next to the saddle",
        f"The motion is within {NEAR} rad of the saddle from {start:.2f} to {end:.2f} s; there "
        f"every error grows as e^(λt) with λ = {saddle.rate:.3f}/s, whatever its cause, until it "
        "is no longer small.",
        traces,
        logarithmic("|error of θ| [rad]"),
        wide=True,
        height=400,
    )


def _rates(
    saddle: Saddle, stay: tuple[float, float], convergence: Sequence[ConvergenceStudy], note: str
) -> Table | None:
    """Fitted growth rates over the second half of the stay, where the growing mode dominates,
    while the error is small."""
    start, end = stay
    rows = []
    for c in convergence:
        if c.trace is None:
            continue
        times, errors = np.array(c.trace.times), np.abs(c.trace.errors)
        small = (errors < LINEAR) & (errors > 0.0)
        lost = times[errors >= LINEAR]
        until = min(end, float(lost[0])) if lost.size else end
        used = small & (times >= (start + until) / 2) & (times < until)
        rate = (
            f"{np.polyfit(times[used], np.log(errors[used]), 1)[0]:.2f}"
            if used.sum() > FEW
            else "too few samples"
        )
        left = f"{notation.number(float(lost[0]))} s" if lost.size else "the end"
        rows.append(row(method_cell(c.method), Cell(rate, "number"), Cell(left, "number")))
    if not rows:
        return None
    caption = f"Growth next to the saddle, where theory gives λ = {saddle.rate:.3f}/s"
    heads = ("method", "fitted rate [1/s]", f"error below {LINEAR} rad until")
    return Table(caption, heads, tuple(rows), note)
