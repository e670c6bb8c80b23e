"""Geometry of a figure for its SVG template: curves, maps, ticks and names in pixels."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType, SimpleNamespace
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.reports.view.axis import Axis, Ticks
from plumbob.reports.view.content import Figure, PlotlyLayout, PlotlyTrace
from plumbob.reports.view.palette import INK
from plumbob.reports.view.plotly_figure import FRONT
from plumbob.reports.view.point_names import placed_names

WIDTH, WIDE_WIDTH, SQUARE = 560, 860, 400  # [px]
# margins [px]; SCALE is the right margin of a map, which holds its colour scale
LEFT_MARGIN, RIGHT_MARGIN, SCALE, TOP_MARGIN, BOTTOM_MARGIN = 64, 18, 68, 10, 40
# [px] widest letter at full size, and in a shrunken picture
TICK_LETTER_WIDTH, LARGE_LETTER = 7.4, 10.0
MOST_TICKS, MAP_SHADES = 6, 16
# SVG paths of marks by plotly's names, in tenths of a pixel from the middle of the mark. A disc is
# the round end of a line of zero length.
GLYPHS = MappingProxyType(
    {
        "circle": "h0",
        "circle-open": "m-30 0a30 30 0 1 0 60 0a30 30 0 1 0-60 0",
        "square": "m-30-30h60v60h-60z",
        "diamond": "m0-42l42 42l-42 42l-42-42z",
        "triangle-up": "m0-42l40 70h-80z",
        "triangle-down": "m0 42l40-70h-80z",
        "pentagon": "m0-42l40 29l-15 47h-50l-15-47z",
        "hexagon": "m-40 0l20-35h40l20 35l-20 35h-40z",
        "x": "m-32-32l64 64m0-64l-64 64",
        "star": "m0-46l11 35h37l-30 22l11 35l-29-21l-29 21l11-35l-30-22h37z",
    }
)
DASH_PATTERNS = MappingProxyType({"dash": "6 4", "dot": "2 3"})
DOT = "●"
BAND_WIDTH = 4.0  # [px] width from which a line is a band
MOST_LABELS = 14  # largest number of curves that are named at their ends
LABEL_SPACING = 12.0  # [px] between points of a curve that a name does not cover


@dataclass(frozen=True)
class SvgPath:
    """An SVG path in tenths of a pixel, with its colours, line width and dashes."""

    d: str
    fill: str = ""
    stroke: str = ""
    width: float = 0.0
    dashes: str = ""
    opacity: float | None = None


SvgDrawing = SimpleNamespace
"""The values of the SVG template: size [px], the colour that a dark page changes, axes and their
ticks, paths in tenths of a pixel, names of points and of curves, colours by names of curves, the
shades of a map with the ticks of its scale, and the legend: of each curve without a name at its end
the name, the colour, the dashes, and whether it is a band."""


def svg_drawing(figure: Figure, chosen: Sequence[str] = ()) -> SvgDrawing | None:
    """Returns the drawing of a figure, restricted to the curves of the `chosen` methods if the
    figure has any of these; None if no value has a place on one of the axes."""
    traces = drawn_traces(figure, chosen)
    layout = figure.layout
    width = WIDE_WIDTH if figure.wide else WIDTH
    square = "scaleanchor" in layout["yaxis"]
    height = SQUARE if square else figure.height
    first = traces[0] if "z" in traces[0] else None
    longest = max(map(len, layout["yaxis"].get("ticktext", ())), default=0)
    right = width - (SCALE if first else RIGHT_MARGIN)
    x = _axis(
        layout["xaxis"], traces, "x", max(LEFT_MARGIN, 24 + TICK_LETTER_WIDTH * longest), right
    )
    y = _axis(layout["yaxis"], traces, "y", height - BOTTOM_MARGIN, TOP_MARGIN)
    if x is None or y is None:
        return None
    if square:
        scale = max(abs(x.scale), abs(y.scale))
        x, y = x.scaled(scale), y.scaled(scale)
    drawn = SvgDrawing(
        width=width,
        height=height,
        layout=layout,
        ink=INK,
        x=x,
        y=y,
        across=_ticks(layout["xaxis"], x),
        up=_ticks(layout["yaxis"], y),
        paths=list(_paths(traces, x, y)),
        shades=[],
        scale=[],
        **_names(layout, traces, x, y),
    )
    if first:
        scale_axis = Axis(first["zmin"], first["zmax"], y.start, y.end, False)
        drawn.scale = _ticks(first["colorbar"], scale_axis)
        drawn.shades = [_shade(first, (k + 0.5) / MAP_SHADES) for k in range(MAP_SHADES)]
    return drawn


def _paths(traces: Sequence[PlotlyTrace], x: Axis, y: Axis) -> Iterator[SvgPath]:
    """Yields the paths of all traces: the cells of a map, the line and the marks of a curve."""
    for trace in traces:
        yield from _map(trace, x, y) if "z" in trace else _marks(trace, x, y)


def _names(
    layout: PlotlyLayout, traces: Sequence[PlotlyTrace], x: Axis, y: Axis
) -> Mapping[str, Any]:
    """Returns the names in a drawing: `point_names`, the labels beside points and at ends of
    curves; `colours` by the names of curves; and `names`, the legend of the curves without such a
    label."""
    named = _named_traces(layout, traces)
    ends = _curve_ends(named, x, y) if len(named) <= MOST_LABELS else []
    on_curves = _curve_points(traces, x, y) if ends else ()
    point_names = placed_names(_points_with_names(traces, x, y), x, y, ends, on_curves)
    placed = {name.text for name in point_names}
    return {
        "point_names": point_names,
        "colours": {f"{DOT} {name}": trace["line"]["color"] for name, trace in named.items()},
        "names": [
            (name, trace["line"]["color"], dashes(trace), trace["line"]["width"] >= BAND_WIDTH)
            for name, trace in named.items()
            if f"{DOT} {name}" not in placed
        ],
    }


def _named_traces(
    layout: PlotlyLayout, traces: Sequence[PlotlyTrace]
) -> Mapping[str, PlotlyTrace]:
    """Returns the last trace of each name that a reader needs to know; none if the layout shows no
    legend and no curve belongs to a method."""
    if not layout.get("showlegend") and not any("meta" in trace for trace in traces):
        return {}
    return {
        trace["name"]: trace
        for trace in traces
        if "z" not in trace and trace["name"] and trace.get("showlegend", True)
    }


def _curve_ends(
    named: Mapping[str, PlotlyTrace], x: Axis, y: Axis
) -> list[tuple[float, float, str]]:
    """Returns the last point (x [px], y [px]) of each curve in the drawing, with the curve's name
    after a dot, which takes the curve's colour. Bands and marks without a line have no end."""
    ends = []
    for name, trace in named.items():
        if _is_curve(trace):
            places = _places(trace, x, y)
            if len(places):
                ends.append((*places[-1].tolist(), f"{DOT} {name}"))
    return ends


def _is_curve(trace: PlotlyTrace) -> bool:
    """Returns whether a trace is drawn as a curve: neither as a map, a band nor as marks alone."""
    return "lines" in trace.get("mode", "") and trace["line"]["width"] < BAND_WIDTH


def _curve_points(traces: Sequence[PlotlyTrace], x: Axis, y: Axis) -> Array:
    """Returns points on the curves of `traces`, LABEL_SPACING apart, shape (n, 2) [px]."""
    points = [np.empty((0, 2))]
    for trace in filter(_is_curve, traces):
        places = _places(trace, x, y)
        if len(places) > 1:
            steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
            along = np.concatenate([[0.0], np.cumsum(steps)])
            grid = np.arange(0.0, along[-1], LABEL_SPACING)
            points.append(np.column_stack([np.interp(grid, along, c) for c in places.T]))
    return np.concatenate(points)


def _places(trace: PlotlyTrace, x: Axis, y: Axis) -> Array:
    """Returns the points of a trace that have a place on both axes, shape (n, 2) [px]."""
    places = np.column_stack([x.along(trace["x"]), y.along(trace["y"])])
    finite: Array = places[np.isfinite(places.sum(axis=1))]
    return finite


def drawn_traces(figure: Figure, chosen: Sequence[str]) -> Sequence[PlotlyTrace]:
    """Returns the traces of a figure that its picture shows: the traces of the `chosen` methods and
    of the Pareto front; all traces if the figure has none of the `chosen` methods."""
    chosen_traces = [t for t in figure.traces if t.get("meta", FRONT) in (*chosen, FRONT)]
    only_front = all(trace.get("meta") == FRONT for trace in chosen_traces)
    return figure.traces if only_front else chosen_traces


def _axis(
    layout: PlotlyLayout, traces: Sequence[PlotlyTrace], key: str, start: float, end: float
) -> Axis | None:
    """Returns the axis from pixel `start` to pixel `end`, over the range that `layout` declares or,
    by default, over the values `key` ("x" or "y") of all traces; None if there are no values."""
    logarithmic = layout.get("type") == "log"
    values = [value for trace in traces for value in trace[key] if value is not None]
    if logarithmic:
        values = [math.log10(value) for value in values if value > 0.0]
    if not values:
        return None
    low, high = layout.get("range") or (min(values), max(values))
    margin = 0.0
    if ("range" not in layout and "tickvals" not in layout) or high <= low:
        margin = 0.04 * (high - low) or 0.5 * abs(high) or 0.5
    return Axis(low - margin, high + margin, start, end, logarithmic)


def _ticks(layout: PlotlyLayout, axis: Axis) -> Ticks:
    """Returns the ticks that `layout` declares, or ticks at round values; on a horizontal axis,
    only those whose texts do not touch."""
    if "ticktext" not in layout:
        ticks = axis.ticks(MOST_TICKS)
        return separated_ticks(ticks) if axis.end > axis.start else ticks
    return list(zip(axis.along(layout["tickvals"]).tolist(), layout["ticktext"], strict=True))


def separated_ticks(ticks: Ticks) -> Ticks:
    """Returns the ticks of a horizontal axis without each tick whose text would touch the text
    before it. Letters are taken as large as on a telephone, where they are the largest."""
    separated: list[tuple[float, str]] = []
    for place, text in ticks:
        if separated:
            place_before, text_before = separated[-1]
            letters = len(text) + len(text_before)
            if place - place_before < LARGE_LETTER * letters / 2.0:
                continue
        separated.append((place, text))
    return separated


def _marks(trace: PlotlyTrace, x: Axis, y: Axis) -> Iterator[SvgPath]:
    """Yields the path of a trace's line and the path of its marks, as far as the trace has them."""
    places = 10.0 * np.column_stack([x.along(trace["x"]), y.along(trace["y"])])
    finite = np.isfinite(places.sum(axis=1))
    colour = trace["line"]["color"]
    points = places[finite].tolist()
    if "lines" in trace["mode"]:
        smooth = trace["line"]["shape"] == "spline" and len(points) > 2
        yield SvgPath(
            d=_spline(places[finite]) if smooth else _straight_lines(points, finite),
            stroke=colour,
            width=10.0 * trace["line"]["width"],
            dashes=" ".join(f"{length}0" for length in dashes(trace).split()),
            opacity=trace.get("opacity"),
        )
    if "markers" in trace["mode"]:
        size = trace["marker"]["size"]
        name = trace["marker"].get("symbol", "circle")
        shape = GLYPHS.get(name) or GLYPHS[name.removesuffix("-open")]
        most = trace["marker"].get("maxdisplayed") or len(points)
        every = max(1, -(-len(points) // most))
        marks = "".join(f"M{a:.0f} {b:.0f}{shape}" for a, b in points[::every])
        if name == "circle":
            yield SvgPath(marks, stroke=colour, width=10.0 * size)
        elif name == "x" or name.endswith("-open"):
            yield SvgPath(marks, stroke=colour, width=13.0)
        else:
            yield SvgPath(marks, fill=colour, stroke=colour, width=5.0 * size - 24.0)


def _straight_lines(points: Sequence[Sequence[float]], finite: Array) -> str:
    """Returns the SVG path through the `points` of a curve. `finite` says which values of the curve
    have a point: a line ends at a gap."""
    continues = np.append(False, finite[:-1])[finite]
    lines = zip(continues, points, strict=True)
    return "".join(f"{' ' if goes_on else 'M'}{a:.0f} {b:.0f}" for goes_on, (a, b) in lines)


def _spline(points: Array) -> str:
    """Returns the SVG path of the Catmull–Rom spline through the points, shape (n, 2): its tangent
    at a point is parallel to the line between the point before and the point after."""
    tangents = np.gradient(points, axis=0) / 3.0
    controls = np.hstack([(points + tangents)[:-1], (points - tangents)[1:], points[1:]])
    start = "M{:.0f} {:.0f}C".format(*points[0])
    return start + " ".join(f"{number:.0f}" for number in controls.ravel())


def _points_with_names(
    traces: Sequence[PlotlyTrace], x: Axis, y: Axis
) -> list[tuple[float, float, str]]:
    """Returns (x [px], y [px], text) of each point in the traces whose texts are shown."""
    points = []
    for trace in traces:
        if "text" in trace.get("mode", ""):
            places = zip(x.along(trace["x"]), y.along(trace["y"]), trace["text"], strict=True)
            points += [(float(a), float(b), text) for a, b, text in places]
    return points


def _map(trace: PlotlyTrace, x: Axis, y: Axis) -> Iterator[SvgPath]:
    """Yields the cells of a map, as one path for each shade."""
    xs = 10.0 * _edges(x.along(trace["x"]))
    ys = 10.0 * _edges(y.along(trace["y"]))
    above_low = np.array(trace["z"], dtype=float) - trace["zmin"]
    fractions = np.clip(above_low / (trace["zmax"] - trace["zmin"]), 0.0, 1.0)
    shades = np.rint(MAP_SHADES * fractions)
    for shade in np.unique(shades[np.isfinite(shades)]):
        cells = (
            f"M{xs[j]:.0f} {ys[i]:.0f}H{xs[j + 1]:.0f}V{ys[i + 1]:.0f}H{xs[j]:.0f}z"
            for i, j in np.argwhere(shades == shade)
        )
        yield SvgPath("".join(cells), _shade(trace, shade / MAP_SHADES))


def _edges(places: Array) -> Array:
    """Returns the n + 1 edges of n cells whose middles are `places`; the outer edges are the
    middles of the outer cells."""
    return np.concatenate([places[:1], (places[1:] + places[:-1]) / 2, places[-1:]])


def _shade(trace: PlotlyTrace, fraction: float) -> str:
    """Returns the colour of a map at a fraction of its colour scale, as "#rrggbb"."""
    fractions, colours = zip(*trace["colorscale"], strict=True)
    channels = np.array([list(bytes.fromhex(colour[1:])) for colour in colours]).T
    levels = [round(float(np.interp(fraction, fractions, channel))) for channel in channels]
    return "#" + "".join(f"{level:02x}" for level in levels)


def dashes(trace: PlotlyTrace) -> str:
    """Returns the SVG dash pattern of a trace [px]; empty for a solid line."""
    return DASH_PATTERNS.get(trace["line"]["dash"], "")
