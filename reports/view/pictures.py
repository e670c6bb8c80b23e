"""Small pictures of figures as SVG: curves on two axes, which need no script and can be printed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.reports.view.content import Figure
from plumbob.reports.view.palette import GREY

WIDTH, HEIGHT = 320, 190  # of a picture, in its own units
SQUARE = WIDTH - 12  # its height where both axes have one scale: the margins differ by so much
LEFT, RIGHT, TOP, BOTTOM = 46, 8, 8, 34  # margins
MOST_CURVES, MOST_POINTS, MOST_TICKS = 6, 120, 4
DASHES = MappingProxyType({"dash": "6 4", "dot": "2 3", "dashdot": "6 3 2 3"})
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Axis:
    """Where values lie between two ends of a picture."""

    low: float
    high: float
    start: float
    end: float
    logarithmic: bool

    def at(self, value: float) -> float:
        """The place of a value."""
        if self.logarithmic:
            value = math.log10(value)
        return self.start + (value - self.low) / (self.high - self.low) * (self.end - self.start)

    def along(self, values: Sequence[float | None] | Array) -> Array:
        """Places of values; NaN where one has none."""
        numbers = np.asarray(values, dtype=float)
        if self.logarithmic:
            nowhere = np.full_like(numbers, np.nan)
            numbers = np.log10(numbers, out=nowhere, where=numbers > 0.0)
        part = (numbers - self.low) / (self.high - self.low)
        return np.asarray(self.start + part * (self.end - self.start))

    def ticks(self, most: int = MOST_TICKS) -> list[tuple[float, str]]:
        """Places of a few round values, and the values as text."""
        if self.logarithmic:
            first, last = math.ceil(self.low - 1e-9), math.floor(self.high + 1e-9)
            every = max(1, math.ceil((last - first + 1) / most))
            powers = range(first, last + 1, every)
            if len(powers) > 1:
                return [(self.at(10.0**p), f"10{str(p).translate(SUPERSCRIPTS)}") for p in powers]
            values = [k * 10.0**p for p in range(first - 1, last + 1) for k in (1, 2, 5)]
            inside = [v for v in values if self.low <= math.log10(v) <= self.high]
            return [(self.at(v), f"{v:g}") for v in inside]
        size = self.high - self.low
        unit = 10.0 ** math.floor(math.log10(size / most))
        step = next(unit * k for k in (1, 2, 5, 10) if size / (unit * k) <= most)
        first = math.ceil(self.low / step)
        count = math.floor(self.high / step) - first + 1
        return [(self.at(step * (first + k)), f"{step * (first + k):g}") for k in range(count)]


def picture(figure: Figure) -> str:
    """A figure's first curves as an SVG element with a text for those who do not see it; empty
    where it has none that can be drawn."""
    traces = [_points(trace, figure.layout) for trace in figure.traces]
    drawn = [(trace, points) for trace, points in zip(figure.traces, traces, strict=True) if points]
    drawn = drawn[:MOST_CURVES]
    if not drawn:
        return ""
    layout = figure.layout
    height, across, up = _axes(layout, [point for _, points in drawn for point in points])
    marks = "".join(_curve(trace, points, across, up) for trace, points in drawn)
    label = escape(f"{figure.title}. {figure.caption}")
    return (
        f'<svg class="picture" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{label}">'
        f"{_frame(layout, across, up)}{marks}</svg>"
    )


def names(figure: Figure) -> list[tuple[str, str, str]]:
    """Names, colours and dashes, empty for a solid line, of the curves of a picture."""
    traces = [t for t in figure.traces if _points(t, figure.layout)][:MOST_CURVES]
    return [(t["name"], colour(t), dashes(t)) for t in traces if t.get("name")]


def _points(trace: Mapping[str, Any], layout: Mapping[str, Any]) -> list[tuple[float, float]]:
    """The points of a trace that can be drawn on these axes, thinned."""
    if trace.get("type", "scatter") != "scatter" or trace.get("yaxis", "y") != "y":
        return []
    positive = tuple(layout[name].get("type") == "log" for name in ("xaxis", "yaxis"))
    points = [
        pair
        for pair in zip(trace["x"], trace["y"], strict=False)
        if all(isinstance(v, (int, float)) and math.isfinite(v) for v in pair)
        and all(v > 0.0 for v, log in zip(pair, positive, strict=True) if log)
    ]
    every = max(1, math.ceil(len(points) / MOST_POINTS))
    return points[::every]


def _axes(
    layout: Mapping[str, Any], points: Sequence[tuple[float, float]]
) -> tuple[int, Axis, Axis]:
    """The height of a picture of these points and its axes, of one scale where the layout asks."""
    height, places = HEIGHT, [list(values) for values in zip(*points, strict=True)]
    if "scaleanchor" in layout["yaxis"]:
        height, places = SQUARE, [places[0] + places[1]] * 2
    across = _axis(layout["xaxis"], places[0], LEFT, WIDTH - RIGHT)
    return height, across, _axis(layout["yaxis"], places[1], height - BOTTOM, TOP)


def _axis(layout: Mapping[str, Any], values: Sequence[float], start: float, end: float) -> Axis:
    logarithmic = layout.get("type") == "log"
    shown = [math.log10(v) for v in values] if logarithmic else list(values)
    low, high = min(shown), max(shown)
    margin = 0.04 * (high - low) or 0.5 * abs(high) or 0.5
    return Axis(low - margin, high + margin, start, end, logarithmic)


def _frame(layout: Mapping[str, Any], across: Axis, up: Axis) -> str:
    bottom, middle = up.start, (up.start + up.end) / 2
    parts = [f'<path class="axes" d="M{LEFT} {TOP}V{bottom}H{WIDTH - RIGHT}"/>']
    for place, text in across.ticks():
        parts.append(f'<text x="{place:.1f}" y="{bottom + 13}" class="middle">{text}</text>')
    for place, text in up.ticks():
        parts.append(f'<path class="grid" d="M{LEFT} {place:.1f}H{WIDTH - RIGHT}"/>')
        parts.append(f'<text x="{LEFT - 4}" y="{place + 4:.1f}" class="end">{text}</text>')
    titles = [escape(layout[name]["title"]["text"]) for name in ("xaxis", "yaxis")]
    parts.append(
        f'<text x="{(LEFT + WIDTH) / 2}" y="{bottom + BOTTOM - 5}" class="middle">'
        f"{titles[0]}</text>"
    )
    parts.append(
        f'<text x="9" y="{middle}" class="middle" transform="rotate(-90 9 {middle})">'
        f"{titles[1]}</text>"
    )
    return "".join(parts)


def _curve(
    trace: Mapping[str, Any], points: Sequence[tuple[float, float]], across: Axis, up: Axis
) -> str:
    places = [f"{across.at(x):.1f} {up.at(y):.1f}" for x, y in points]
    stroke, line = colour(trace), trace.get("line", {})
    dashed = f' stroke-dasharray="{dash}"' if (dash := dashes(trace)) else ""
    mode, paths = trace.get("mode", "lines"), ""
    if "lines" in mode:
        width = min(float(line.get("width", 1.6)), 6.0)
        faint = f' opacity="{trace["opacity"]}"' if "opacity" in trace else ""
        paths += (
            f'<path fill="none" stroke="{stroke}" stroke-width="{width:g}"{dashed}{faint} '
            f'd="M{"L".join(places)}"/>'
        )
    if "markers" in mode:  # round ends of lines without length: one element for all marks
        paths += (
            f'<path stroke="{stroke}" stroke-width="5" stroke-linecap="round" '
            f'd="{"".join(f"M{place}h0" for place in places)}"/>'
        )
    return paths


def colour(trace: Mapping[str, Any]) -> str:
    """The colour of a trace."""
    return str(trace.get("line", {}).get("color") or trace.get("marker", {}).get("color") or GREY)


def dashes(trace: Mapping[str, Any]) -> str:
    """Its dashes, empty for a solid line."""
    return DASHES.get(trace.get("line", {}).get("dash", ""), "")
