"""Curves, points and axes in plotly's format, rounded to what a screen can show."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array
from plumbob.reports.view.axis import power_of_ten
from plumbob.reports.view.content import Figure, PlotlyLayout, PlotlyTrace
from plumbob.reports.view.palette import BLUE, GREY, INK, RED, Style

MAX_CURVE_POINTS = 240  # points of a curve: a screen shows no more
ZERO = 1e-17  # value at which an error of exactly zero is drawn on a logarithmic axis
MOST_POWERS = 5
FOUR_DIGITS = "{:.4g}".format  # four significant digits: more cannot be seen in a figure
FRONT = "front"  # takes the place of a method's name in the trace of the Pareto front
DIVERGING_COLOURS = ((0.0, BLUE), (0.5, "#ffffff"), (1.0, RED))
PLAIN_STYLE = Style(GREY, "circle", 6.0)


def curve(
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    style: Style = PLAIN_STYLE,
    *,
    name: str = "",
    method: str = "",
    colour: str = "",
    dash: str = "solid",
    width: float = 1.6,
    marks: bool = False,
    most_marks: int = 0,
    lines: bool = True,
    smooth: bool = False,
    symbol: str = "",
    size: float = 0.0,
    hints: Sequence[str] = (),
    hint: str = "",
    labels: bool = False,
    **more: Any,
) -> PlotlyTrace:
    """Returns a scatter trace in plotly's format: a curve, points, or both, thinned to
    MAX_CURVE_POINTS points. Of the `marks`, `most_marks` are drawn; 0: all. A `smooth` curve, such
    as an orbit, has no corners at its points.

    `colour`, `symbol` and `size` replace parts of `style`. If `method` is given, the page's
    legend switches the trace on and off with that method. `hint` is plotly's template of the text
    on hover, with %{x}, %{y} and %{text}, the point's entry of `hints`. With `labels`, the hints
    stand beside the points. `more` are further properties of plotly's trace."""
    xs = np.ravel(x)
    ys = np.ravel(y)
    indices = np.linspace(0, len(xs) - 1, min(len(xs), MAX_CURVE_POINTS)).astype(int)
    colour = colour or style.colour
    shape = "spline" if smooth else "linear"
    modes = ("lines", lines), ("markers", marks), ("text", labels)
    trace: dict[str, Any] = {
        "type": "scatter",
        "mode": "+".join(mode for mode, shown in modes if shown),
        "x": rounded(xs[indices]),
        "y": rounded(ys[indices]),
        "name": name or method,
        "line": {"color": colour, "width": width, "dash": dash, "shape": shape},
    }
    if marks:
        trace["marker"] = {
            "color": colour,
            "size": size or style.size,
            "symbol": symbol or style.marker,
            "maxdisplayed": most_marks,
        }
    if method:
        trace["meta"] = method  # the page's legend finds the traces of a method by this entry
    if hints:
        trace["text"] = [hints[i] for i in indices]
    if labels:
        trace["textposition"] = "top center"
    if hint:
        trace["hovertemplate"] = f"{hint}<extra></extra>"
    return {**trace, **more}


def prediction(
    x: npt.ArrayLike, y: npt.ArrayLike, name: str = "", method: str = ""
) -> PlotlyTrace:
    """Returns the curve of a prediction: dotted in the page's ink, as no other curve is."""
    return curve(x, y, name=name, method=method, colour=INK, dash="dot", width=1.4)


def figure(
    title: str,
    caption: str,
    traces: Sequence[PlotlyTrace],
    x: PlotlyLayout,
    y: PlotlyLayout,
    *,
    legend: bool = False,
    height: int = 340,
    wide: bool = False,
) -> Figure:
    """Returns a figure with one pair of axes; with `legend`, the traces are named, in it or below
    it. A logarithmic vertical axis has a tick for values of zero."""
    layout = {"xaxis": x, "yaxis": _with_zero(y, traces), "showlegend": legend}
    return Figure(title, caption, tuple(traces), layout, height, wide)


def _with_zero(axis: PlotlyLayout, traces: Sequence[PlotlyTrace]) -> PlotlyLayout:
    """Returns a vertical axis, with the tick "0" at `ZERO` if it is logarithmic and a value is
    zero. Its other ticks are at most MOST_POWERS powers of ten."""
    values = [v for trace in traces if "z" not in trace for v in trace["y"] if v is not None]
    if axis.get("type") != "log" or ZERO not in values:
        return axis
    others = [value for value in values if value > ZERO] or [1.0]
    first = math.floor(math.log10(min(others)))
    last = math.ceil(math.log10(max(others)))
    powers = range(first, last + 1, 1 + (last - first) // MOST_POWERS)
    return {
        **axis,
        "range": (math.log10(ZERO) - 0.5, last + 0.2),
        "tickvals": (ZERO, *(10.0**power for power in powers)),
        "ticktext": ("0", *map(power_of_ten, powers)),
    }


def over_time(
    title: str, caption: str, traces: Sequence[PlotlyTrace], y: PlotlyLayout, **more: Any
) -> Figure:
    """Returns a figure over time [s] with a legend; `more` are further arguments of `figure`."""
    return figure(title, caption, traces, linear("time [s]"), y, legend=True, **more)


def marks(
    x: npt.ArrayLike, y: npt.ArrayLike, colour: str, name: str, size: float = 6
) -> PlotlyTrace:
    """Returns a trace of marks without a line, for the samples of a run."""
    return curve(x, y, colour=colour, marks=True, lines=False, name=name, size=size)


def heat(
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    rows: npt.ArrayLike,
    low: float,
    high: float,
    colours: Sequence[tuple[float, str]] = DIVERGING_COLOURS,
    **more: Any,
) -> PlotlyTrace:
    """Returns a heat map of the values `rows`, shape (y, x), coloured from `low` to `high`, by
    default from blue to red. Values outside are clipped. `more` are further properties of plotly's
    trace."""
    return {
        "type": "heatmap",
        "x": rounded(x),
        "y": rounded(y),
        "z": [rounded(row) for row in np.clip(np.asarray(rows, dtype=float), low, high)],
        "zmin": low,
        "zmax": high,
        "colorscale": colours,
        "colorbar": {"thickness": 10},
        **more,
    }


def linear(title: str, **more: Any) -> PlotlyLayout:
    """Returns a linear axis; `more` are further properties of plotly's axis."""
    return {"title": {"text": title}, **more}


def logarithmic(title: str, **more: Any) -> PlotlyLayout:
    """Returns a logarithmic axis with labels as powers of ten; `more` are further properties of
    plotly's axis."""
    look = {"type": "log", "exponentformat": "power", "nticks": 6, "tickfont": {"size": 10.5}}
    return linear(title, **look, **more)


def spacious(title: str, values: npt.ArrayLike) -> PlotlyLayout:
    """Returns a logarithmic axis for positive values, at least 2.2 decades long, with margins for
    the names beside the outermost points. Values that are powers of ten are not at its ends."""
    powers = np.log10(np.asarray(values, dtype=float))
    middle = 0.5 * float(powers.max() + powers.min())
    half = max(1.1, 0.65 * float(np.ptp(powers)))
    return logarithmic(title, range=(middle - half, middle + half))


def positive_magnitudes(values: npt.ArrayLike) -> Array:
    """Returns the magnitudes for a logarithmic axis; zero becomes `ZERO`, at the bottom."""
    return np.asarray(np.maximum(np.abs(np.asarray(values, dtype=float)), ZERO))


def rounded(values: npt.ArrayLike) -> list[float | None]:
    """Returns values rounded to the digits that can be seen; None, a gap, for each that is not
    finite."""
    numbers = [float(FOUR_DIGITS(number)) for number in np.ravel(values).astype(float).tolist()]
    return [number if math.isfinite(number) else None for number in numbers]
