"""Plots of an exact motion's modes: which support slides, holds a pivot or rests, and when."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.reports.view.content import Figure
from plumbob.reports.view.traces import Trace, curve, figure, linear, logarithmic

MODES = (("rest", "#808080"), ("pivot", "#d55e00"), ("slide", "#0072b2"))  # bottom to top
SUPPORTS = ("#0072b2", "#e69f00", "#009e73")
FINE = 1200  # times of a curve of speeds, and more beside every event
NEAR = 1e-12  # of the largest slip speed, where a support at rest is drawn
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
            **curve(stops, [2.0] * len(stops), colour="#e69f00", marks=True, lines=False,
                    hint="a support stops and leaves at once<br>t = %{x:.4g} τ"),
            "marker": {"color": "#e69f00", "size": 12, "symbol": "diamond"},
        })  # fmt: skip
    labels = {"tickvals": list(range(len(MODES))), "ticktext": [name for name, _ in MODES],
              "range": [-0.6, len(MODES) - 0.4]}  # fmt: skip
    return figure(
        "Modes over time",
        f"{' → '.join(_words(motion))}.",
        traces, linear("time [τ]"), linear("", **labels), height=220,
    )  # fmt: skip


def _words(motion: ThreePointMotion) -> list[str]:
    """The sequence of modes in words."""
    found = []
    for before, event in pairwise((None, *motion.events)):
        assert event is not None
        name = f"A{event.support + 1}"
        again = before is not None and before.mode == event.mode == "slide"
        if again:
            found.append(f"{name} stops and leaves at once")
        else:
            found.append(f"pivot about {name}" if event.mode == "pivot" else event.mode)
    return found


def slip_speeds(motion: ThreePointMotion, times: Array) -> Array:
    """|v_i| [m/s] of each support, shape (3, n), at `times` [s], shape (n,)."""
    pose = motion.at(times)
    own = (pose.velocity @ [1.0, 1j]) * np.exp(-1j * pose.heading)
    supports = np.asarray(motion.capsule.supports) @ [1.0, 1j]
    return np.asarray(np.abs(own + 1j * pose.angular_velocity * supports[:, None]))


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
    for number, (line, colour) in enumerate(zip(speeds, SUPPORTS, strict=True)):
        for part in np.array_split(np.arange(times.size), -(-times.size // 290)):
            reach = np.append(part, part[-1] + 1)[: times.size - part[0]]
            drawn = np.maximum(line[reach] / top, NEAR)
            one = curve(times[reach] / unit, drawn, colour=colour, name=f"A{number + 1}")
            first = bool(part[0] == 0)
            traces.append({**one, "legendgroup": f"A{number + 1}", "showlegend": first})
    return figure(
        "Slip speed of each support",
        f"Over the largest, {top:.3g} m/s. A support at rest lies at the bottom.",
        traces, linear("time [τ]"), logarithmic("|vᵢ| / largest"), legend=True, height=320,
    )  # fmt: skip
