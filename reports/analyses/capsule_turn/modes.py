"""Modes of an exact turn: which support slides, is a pivot or rests, and what makes a case hard."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import lowest_normal_forces
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.analyses.measurements import problem
from plumbob.reports.view.content import Cell, Figure, Table, method_cell, row, value
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.palette import BLUE, GREEN, GREY, ORANGE, RED
from plumbob.reports.view.traces import Trace, curve, figure, linear, logarithmic

MODES = (("rest", GREY), ("pivot", RED), ("slide", BLUE))  # bottom to top
SUPPORTS = (BLUE, ORANGE, GREEN)
FINE = 1200  # times of a curve of speeds, and more beside every event
NEAR = 1e-12  # of the largest slip speed: where a support at rest is drawn
LATE = 1.08  # of the time to rest


def figures(motion: ThreePointMotion, unit: float) -> tuple[Figure, Figure]:
    """Modes over time as a strip, and the slip speed of each support; `unit` [s] is that of the
    time axis, a turn's half time."""
    return strip(motion, unit), slips(motion, unit)


def strip(motion: ThreePointMotion, unit: float) -> Figure:
    """One bar for each stay in a mode, from event to event."""
    ends = [*(event.time for event in motion.events), LATE * motion.rest_time]
    x: dict[str, list[float]] = {name: [] for name, _ in MODES}
    y: dict[str, list[float]] = {name: [] for name, _ in MODES}
    hints: dict[str, list[str]] = {name: [] for name, _ in MODES}
    for event, (begin, end) in zip(motion.events, pairwise(ends), strict=True):
        level = float([name for name, _ in MODES].index(event.mode))
        about = event.mode + (f" about A{event.support + 1}" if event.mode == "pivot" else "")
        if event.mode == "slide" and event.support >= 0:
            about += f", A{event.support + 1} having just slipped"
        x[event.mode] += [begin / unit, end / unit, math.nan]
        y[event.mode] += [level, level, math.nan]
        hints[event.mode] += [about, about, ""]
    traces: list[Trace] = [
        {**curve(x[name], y[name], colour=colour, width=16.0, name=name, hints=hints[name],
                 hint="%{text}<br>t = %{x:.4g} τ", marks=True)}
        for name, colour in MODES
        if x[name]
    ]  # fmt: skip
    stops = [now.time / unit for before, now in pairwise(motion.events)
             if before.mode == now.mode == "slide"]  # fmt: skip
    if stops:
        traces.append({
            **curve(stops, [2.0] * len(stops), colour=ORANGE, marks=True, lines=False,
                    hint="a support stops and slides on at once<br>t = %{x:.4g} τ"),
            "marker": {"color": ORANGE, "size": 12, "symbol": "diamond"},
        })  # fmt: skip
    labels = {"tickvals": list(range(len(MODES))), "ticktext": [name for name, _ in MODES],
              "range": [-0.6, len(MODES) - 0.4]}  # fmt: skip
    return figure(
        "Modes over time: slide, pivot about a support, rest",
        f"{' → '.join(_words(motion))}.",
        traces, linear("time [τ]"), linear("", **labels), height=220,
    )  # fmt: skip


def _words(motion: ThreePointMotion) -> list[str]:
    """The sequence of modes in words."""
    phrases = []
    for before, event in pairwise((None, *motion.events)):
        assert event is not None
        name = f"A{event.support + 1}"
        again = before is not None and before.mode == event.mode == "slide"
        if again:
            phrases.append(f"{name} stops and slides on at once")
        else:
            phrases.append(f"pivot about {name}" if event.mode == "pivot" else event.mode)
    return phrases


def slip_speeds(motion: ThreePointMotion, times: Array) -> Array:
    """|v_i| [m/s] of each support, shape (3, n), at `times` [s], shape (n,)."""
    pose = motion.at(times)
    velocity = (pose.velocity @ [1.0, 1j]) * np.exp(-1j * pose.heading)
    supports = np.asarray(motion.capsule.supports) @ [1.0, 1j]
    return np.asarray(np.abs(velocity + 1j * pose.angular_velocity * supports[:, None]))


def slips(motion: ThreePointMotion, unit: float) -> Figure:
    """Slip speed of each support on a logarithmic axis, resting ones at its bottom."""
    end = LATE * motion.rest_time
    beside = np.geomspace(1e-9, 1e-2, 22) * end
    marks = [event.time + side for event in motion.events for side in (*-beside, 0.0, *beside)]
    even = np.linspace(0.0, end, FINE // 8)
    times = np.unique(np.clip([*even, *marks], 0.0, end))
    speeds = slip_speeds(motion, times)
    top = float(speeds.max()) or 1.0
    traces: list[Trace] = []
    for place, (line, colour) in enumerate(zip(speeds, SUPPORTS, strict=True)):
        for part in np.array_split(np.arange(times.size), -(-times.size // 290)):
            reach = np.append(part, part[-1] + 1)[: times.size - part[0]]
            drawn = np.maximum(line[reach] / top, NEAR)
            trace = curve(times[reach] / unit, drawn, colour=colour, name=f"A{place + 1}")
            first = bool(part[0] == 0)
            traces.append({**trace, "legendgroup": f"A{place + 1}", "showlegend": first})
    return figure(
        "Slip speed of each support",
        f"Over the largest, {top:.3g} m/s. A support at rest lies at the bottom.",
        traces, linear("time [τ]"), logarithmic("|vᵢ| / largest"), legend=True, height=320,
    )  # fmt: skip


def hard(study: Study, scene: Scene) -> tuple[Figure | Table, ...]:
    """The exact motion's modes and slips, what makes the case hard in numbers, and each method's
    error at the end."""
    turned = problem(scene.name).motion
    move = turned.manoeuvre
    lowest, _ = lowest_normal_forces(move.capsule, move.track)
    about = (
        ("ε", move.epsilon),
        ("Zτ² [rad]", move.slider_angle),
        ("turns", float(turned.count)),
        ("smallest Nᵢ over (M+m) g", float(min(lowest)) / move.capsule.weight),
        ("largest a Ω² [m/s²]", move.radius * (move.angular_acceleration * move.half_time) ** 2),
        ("at rest from [τ]", turned.single.rest_time / move.half_time),
        ("body angle at the end [rad]", float(turned.at(scene.duration).heading[0])),
    )
    numbers = Table(
        "What makes it hard", tuple(name for name, _ in about),
        (row(*(value(size, 6) for _, size in about)),),
        "" if turned.count == 1 else "The modes are those of the first turn; all are the same.",
    )  # fmt: skip
    return (*figures(turned.single, move.half_time), numbers, *_events(scene), *_ends(study, scene))


def _events(scene: Scene) -> tuple[Table, ...]:
    turned = problem(scene.name).motion
    tau = turned.manoeuvre.half_time
    last = turned.single.rest_time
    following = [*(event.time for event in turned.single.events[1:]), math.inf]
    rows = [
        row(value(event.time / tau, 6), event.mode,
            f"A{event.support + 1}" if event.support >= 0 else "",
            value((end - event.time) / tau if event.time < last else None, 4))
        for event, end in zip(turned.single.events, following, strict=True)
    ]  # fmt: skip
    heads = ("from [τ]", "mode", "support at rest, or starting to slip", "lasts [τ]")
    return (Table("Events of the exact motion", heads, tuple(rows), folded=True),)


def _ends(study: Study, scene: Scene) -> tuple[Table, ...]:
    rows = []
    for convergence in study.convergence:
        if convergence.scene != scene.name:
            continue
        done = [m for m in convergence.measurements if m.status == "done"]
        if not done:
            why = convergence.measurements[-1] if convergence.measurements else None
            if why is not None and why.status == "diverged":
                rows.append(row(method_cell(convergence.method), value(why.step),
                                Cell(why.reason, span=4)))  # fmt: skip
            continue
        coarse, fine = done[0], done[-1]
        error = fine.errors["body_angle"]
        predicted = error.predicted.end if error.predicted else None
        order = None if convergence.order is None else convergence.order.slope
        rows.append(
            row(method_cell(convergence.method), Cell(short(fine.step), "number"),
                value(coarse.errors["body_angle"].end), value(error.end), value(predicted),
                value(order))
        )  # fmt: skip
    if not rows:
        return ()
    heads = ("method", "finest step [s]", "error at the coarsest step [rad]", "at the finest [rad]",
             "predicted [rad]", "order")  # fmt: skip
    note = f"Over {number(scene.duration)} s. The order is that of the largest error of all times."
    return (Table("Body angle at the end", heads, tuple(rows), note),)
