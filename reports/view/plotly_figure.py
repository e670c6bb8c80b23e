"""Curves, points and axes in plotly's format, rounded to what a screen can show."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.reports.view.content import Figure, Layout, Trace
from plumbob.reports.view.palette import BLUE, GREY, RED, Style

MOST = 300  # points of a curve: a screen shows no more
ZERO = 1e-17  # where an error of exactly zero is drawn on a logarithmic axis
DIGITS = 4
FRONT = "front"  # in place of a method: the Pareto front of the methods that are shown


def curve(
    x: Sequence[float] | Array,
    y: Sequence[float] | Array,
    style: Style | None = None,
    *,
    name: str = "",
    method: str = "",
    colour: str = "",
    dash: str = "solid",
    width: float = 1.6,
    marks: bool = False,
    lines: bool = True,
    hints: Sequence[str] = (),
    hint: str = "",
) -> Trace:
    """A curve, or points: those of `method` follow its style and its place in the legend; `hint`
    is shown on hover, with a point's %{x}, %{y} and %{text}, its entry of `hints`, in it."""
    x, y, hints = _thinned(np.asarray(x, dtype=float), np.asarray(y, dtype=float), hints)
    colour = colour or (style.colour if style else GREY)
    mode = "+".join(word for word, on in (("lines", lines), ("markers", marks)) if on)
    line_dash = style.dash if style and dash == "solid" else dash
    trace: dict[str, Any] = {
        "type": "scatter",
        "mode": mode,
        "x": rounded(x),
        "y": rounded(y),
        "name": name or method,
        "line": {"color": colour, "width": width, "dash": line_dash},
    }
    if marks:
        size = style.size if style else 6
        marker = style.marker if style else "circle"
        trace["marker"] = {"color": colour, "size": size, "symbol": marker}
    if method:
        trace["meta"] = method  # what the page's legend switches off and on
    if hints:
        trace["text"] = list(hints)
    if hint:
        trace["hovertemplate"] = f"{hint}<extra></extra>"
    return trace


def figure(
    title: str,
    caption: str,
    traces: Sequence[Trace],
    x: Layout,
    y: Layout,
    *,
    legend: bool = False,
    height: int = 340,
    wide: bool = False,
) -> Figure:
    """A figure with one pair of axes; `legend` names the traces below it."""
    layout: dict[str, Any] = {"xaxis": _fitted(x, traces, "x"), "yaxis": _fitted(y, traces, "y")}
    layout["showlegend"] = legend
    return Figure(title, caption, tuple(traces), layout, height, wide)


def over_time(title: str, caption: str, traces: Sequence[Trace], y: Layout, **more: Any) -> Figure:
    """A figure over time [s] with a legend; `more` as `figure` takes it."""
    return figure(title, caption, traces, linear("time [s]"), y, legend=True, **more)


def marks(
    x: Sequence[float] | Array, y: Sequence[float] | Array, colour: str, name: str, size: float = 6
) -> Trace:
    """Marks without a line: samples of a run."""
    trace = curve(x, y, colour=colour, marks=True, lines=False, name=name)
    return {**trace, "marker": {**trace["marker"], "size": size}}


def heat(
    x: Sequence[float], y: Sequence[float], rows: Sequence[Sequence[float]], middle: float
) -> Trace:
    """A map of values, white in the middle, as far as 0.5 below it in blue and above it in red."""
    low, high = middle - 0.5, middle + 0.5  # beyond them the colour says enough
    return {
        "type": "heatmap",
        "x": rounded(x),
        "y": rounded(y),
        "z": [rounded(np.clip(row, low, high)) for row in rows],
        "zmin": low,
        "zmax": high,
        "colorscale": [[0.0, BLUE], [0.5, "#ffffff"], [1.0, RED]],
        "colorbar": {"thickness": 10},
    }


def linear(title: str, **more: Any) -> Layout:
    """A linear axis."""
    return {"title": {"text": title}, **more}


def logarithmic(title: str, **more: Any) -> Layout:
    """A logarithmic axis, labelled at powers of ten."""
    return {
        "title": {"text": title},
        "type": "log",
        "exponentformat": "power",
        "tickfont": {"size": 10.5},
        **more,
    }


def positive(values: Sequence[float] | Array) -> Array:
    """Magnitudes as a logarithmic axis takes them: zero is drawn at its bottom."""
    return np.asarray(np.maximum(np.abs(np.asarray(values, dtype=float)), ZERO))


def rounded(values: Sequence[float] | Array) -> list[float | None]:
    """Values with as many digits as can be seen; what is not finite leaves a gap."""
    return [
        float(f"{v:.{DIGITS}g}") if math.isfinite(v) else None for v in np.ravel(values).tolist()
    ]


def _fitted(axis: Layout, traces: Sequence[Trace], letter: str) -> Layout:
    """A logarithmic axis with one label in so many decades that seven fit; on a short one at 1, 2
    and 5."""
    if axis.get("type") != "log":
        return axis
    shown = [v for trace in traces for v in trace[letter] if v is not None and v > 0.0]
    decades = math.log10(max(shown) / min(shown)) if shown else 1.0
    return {**axis, "dtick": max(1, math.ceil(decades / 7)) if decades > 1.5 else "D2"}


def _thinned(x: Array, y: Array, hints: Sequence[str]) -> tuple[Array, Array, Sequence[str]]:
    if len(x) <= MOST:
        return x, y, hints
    kept = np.unique(np.linspace(0, len(x) - 1, MOST).astype(int))
    return x[kept], y[kept], [hints[i] for i in kept] if hints else ()
