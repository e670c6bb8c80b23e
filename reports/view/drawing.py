"""A whole figure as an SVG file: curves and maps, with axes, on light and dark."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from types import MappingProxyType

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.reports.advice.work_precision import front
from plumbob.reports.view.axis import Axis
from plumbob.reports.view.content import Figure, Layout, Trace
from plumbob.reports.view.palette import GREY
from plumbob.reports.view.plotly_figure import FRONT

WIDTH, WIDE, SQUARE = 560, 860, 400  # [px]
LEFT, RIGHT, SCALE, TOP, BOTTOM = 64, 18, 68, 10, 40  # margins [px], with a map's scale in place
LETTER = 7.4  # [px] at most
NARROW = 0.9  # of its width: a picture that is shown smaller has larger letters
MOST_TICKS, SHADES, POINTS = 6, 16, 150  # of a curve: about a point in three pixels
STYLE = (
    "<style>text{font:12px Arial,sans-serif;fill:#4d565f}.m{text-anchor:middle}.e{text-anchor:end}"
    ".a{stroke:#b4bcc4}.g{stroke:#e6e9ec}@media(prefers-color-scheme:dark){text{fill:#b4bec7}"
    ".a{stroke:#4b565f}.g{stroke:#2a3137}}@media(max-width:%dpx){text{font-size:16px}}</style>"
)
# Marks by plotly's names: corners, the direction of the first one in half turns, and how far the
# middles of the sides are from the centre, relative to the corners.
GLYPHS: Mapping[str, tuple[int, float, float]] = MappingProxyType(
    {
        "square": (4, 0.25, 0.71),
        "diamond": (4, 0.0, 0.71),
        "triangle-up": (3, -0.5, 0.5),
        "triangle-down": (3, 0.5, 0.5),
        "x": (4, 0.25, 0.35),
        "star": (4, 0.0, 0.45),
    }
)
ROUND = (6, 0.0, 0.87)
DASHES = MappingProxyType({"dash": "6 4", "dot": "2 3", "dashdot": "6 3 2 3"})


@dataclass(frozen=True)
class Drawing:
    """An SVG file and its size [px], with the names, colours and dashes of its curves."""

    svg: str
    width: int
    height: int
    names: tuple[tuple[str, str, str], ...]


def drawing(figure: Figure, chosen: Sequence[str] = ()) -> Drawing | None:
    """A figure as an SVG file, of curves that belong to methods those of the `chosen` ones, if
    there are any; None where nothing has a place on its axes."""
    traces, layout = shown(figure, chosen), figure.layout
    width = WIDE if figure.wide else WIDTH
    height = SQUARE if "scaleanchor" in layout["yaxis"] else figure.height
    if (axes := _both(layout, traces, width, height)) is None:
        return None
    x, y = axes
    marks = "".join(part for trace in traces for part in _marks(trace, x, y))
    box = (x.start, TOP, x.end - x.start, y.start - TOP)
    inside = 'x="{:g}" y="{:g}" width="{:g}" height="{:g}"'.format(*box)
    units = " ".join(f"{10 * v:g}" for v in box)
    text = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}">'
        f"{STYLE % (NARROW * width)}{''.join(_axes(layout, x, y))}"
        f'<svg {inside} viewBox="{units}" fill="none" stroke-linejoin="round">{marks}</svg>'
        f"{''.join(_scale(traces[0], x.end, y))}</svg>"
    )
    named = layout.get("showlegend") or any("meta" in t for t in traces)
    legend = {t["name"]: t for t in traces if named and t["name"] and t.get("showlegend", True)}
    names = tuple((name, colour(t), dashes(t)) for name, t in legend.items())
    return Drawing(text, width, height, names)


def _both(
    layout: Layout, traces: Sequence[Trace], width: float, height: float
) -> tuple[Axis, Axis] | None:
    """The axes in a drawing of a size [px]; None where one has no values."""
    longest = max(map(len, layout["yaxis"].get("ticktext", ())), default=0)
    right = width - (SCALE if traces[0]["type"] == "heatmap" else RIGHT)
    x = _axis(layout["xaxis"], traces, "x", max(LEFT, 24 + LETTER * longest), right)
    y = _axis(layout["yaxis"], traces, "y", height - BOTTOM, TOP)
    if x is None or y is None or "scaleanchor" not in layout["yaxis"]:
        return None if x is None or y is None else (x, y)
    scale = max((a.high - a.low) / abs(a.end - a.start) for a in (x, y))
    return _scaled(x, scale), _scaled(y, scale)


def shown(figure: Figure, chosen: Sequence[str]) -> list[Trace]:
    """The traces of a figure that a picture has: of the `chosen` methods, where one has any, with
    the Pareto front of these."""
    kept = [t for t in figure.traces if t.get("meta", FRONT) in (*chosen, FRONT)]
    if not any("meta" not in t or t["meta"] != FRONT for t in kept):
        kept = list(figure.traces)
    points = [
        (1.0 / x, y, x)
        for t in kept
        if "meta" in t and t["meta"] != FRONT
        for x, y in zip(t["x"], t["y"], strict=True)
        if x and y
    ]
    best = front(points, lambda point: point[:2])
    edge = {"x": [x for _, _, x in best], "y": [y for _, y, _ in best]}
    return [{**t, **edge} if t.get("meta") == FRONT else t for t in kept]


def _axis(
    layout: Layout, traces: Sequence[Trace], key: str, start: float, end: float
) -> Axis | None:
    """An axis with the values of all traces, or of a declared range; None without any."""
    logarithmic = layout.get("type") == "log"
    values = [v for trace in traces for v in trace[key] if v is not None]
    places = [math.log10(v) for v in values if v > 0.0] if logarithmic else values
    if not places:
        return None
    low, high = layout.get("range") or (min(places), max(places))
    apart = "range" not in layout and "tickvals" not in layout
    margin = (0.04 * (high - low) or 0.5 * abs(high) or 0.5) if apart or high <= low else 0.0
    return Axis(low - margin, high + margin, start, end, logarithmic)


def _scaled(axis: Axis, scale: float) -> Axis:
    """An axis about the same middle with so many units to a pixel."""
    middle, half = (axis.low + axis.high) / 2, abs(axis.end - axis.start) * scale / 2
    return replace(axis, low=middle - half, high=middle + half)


def _axes(layout: Layout, x: Axis, y: Axis) -> Iterator[str]:
    """Lines, ticks and titles of the axes."""
    titles = [escape(layout[name]["title"]["text"]) for name in ("xaxis", "yaxis")]
    across, up = _ticks(layout["xaxis"], x), _ticks(layout["yaxis"], y)
    grid = [f"M{place:.0f} {TOP}V{y.start:g}" for place, _ in across]
    grid += [f"M{x.start:g} {place:.0f}H{x.end:g}" for place, _ in up]
    yield f'<path class="g" d="{"".join(grid)}"/>'
    yield f'<path class="a" fill="none" d="M{x.start:g} {TOP}V{y.start:g}H{x.end:g}"/>'
    for place, text in (*across, ((x.start + x.end) / 2, titles[0])):
        down = 14 if (place, text) in across else 31
        yield f'<text class="m" x="{place:.0f}" y="{y.start + down:g}">{text}</text>'
    for place, text in up:
        yield f'<text class="e" x="{x.start - 5:g}" y="{place + 4:.0f}">{text}</text>'
    middle = (y.start + TOP) / 2
    turned = f'transform="rotate(-90 13 {middle:g})"'
    yield f'<text class="m" x="13" y="{middle:g}" {turned}>{titles[1]}</text>'


def _ticks(layout: Layout, axis: Axis) -> list[tuple[float, str]]:
    if "ticktext" not in layout:
        return axis.ticks(MOST_TICKS)
    places = axis.along(layout["tickvals"]).tolist()
    return list(zip(places, map(escape, layout["ticktext"]), strict=True))


def _marks(trace: Trace, x: Axis, y: Axis) -> Iterator[str]:
    """The elements of a trace, in tenths of a pixel."""
    if trace["type"] == "heatmap":
        yield from _map(trace, x, y)
        return
    places, mode = 10.0 * np.column_stack([x.along(trace["x"]), y.along(trace["y"])]), trace["mode"]
    if "lines" in mode:
        dash = " ".join(f"{10 * int(n)}" for n in dashes(trace).split())
        look = f'stroke="{colour(trace)}" stroke-width="{10.0 * trace["line"]["width"]:g}"'
        look += f' stroke-dasharray="{dash}"' if dash else ""
        look += f' opacity="{trace["opacity"]}"' if "opacity" in trace else ""
        gaps = np.flatnonzero(~np.isfinite(places).all(axis=1))
        runs = (part[np.isfinite(part).all(axis=1)] for part in np.split(places, gaps))
        path = "".join(_path(_thinned(run)) for run in runs if len(run) > 1)
        yield f'<path {look} d="{path}"/>'
    if "markers" in mode:
        yield _dots(trace, places)


def _thinned(places: Array) -> Array:
    """As many points of a curve as a picture shows."""
    kept = np.linspace(0, len(places) - 1, min(len(places), POINTS)).astype(int)
    return np.asarray(places[kept])


def _path(places: Array) -> str:
    """A path through points, in whole numbers and by differences, which are short."""
    numbers = np.rint(places).astype(int)
    steps = " ".join(map(str, np.diff(numbers, axis=0).ravel().tolist())).replace(" -", "-")
    return f"M{numbers[0, 0]} {numbers[0, 1]}l{steps}"


def _dots(trace: Trace, places: Array) -> str:
    """The marks of a trace as one path; discs are round ends of lines without length."""
    stroke, name = colour(trace), trace["marker"].get("symbol", "circle")
    size = 5.0 * trace["marker"]["size"]
    look, shape = f'stroke-width="{2 * size:g}" stroke-linecap="round"', "h0"
    if name != "circle":
        corners, first, inner = GLYPHS.get(name.removesuffix("-open"), ROUND)
        number = np.arange(2 * corners)
        angles = np.pi * (first + number / corners)
        radii = 1.2 * size * np.where(number % 2, inner, 1.0)
        shape = f"m{_path(np.column_stack([radii * np.cos(angles), radii * np.sin(angles)]))[1:]}z"
        look = 'stroke-width="13"' if name.endswith("-open") else f'fill="{stroke}"'
    dots = "".join(f"M{x:.0f} {y:.0f}{shape}" for x, y in places if math.isfinite(x + y))
    return f'<path stroke="{stroke}" {look} d="{dots}"/>'


def _map(trace: Trace, x: Axis, y: Axis) -> Iterator[str]:
    """The cells of a map, those of one shade as one path."""
    xs, ys = (10.0 * _edges(axis.along(trace[key])) for key, axis in (("x", x), ("y", y)))
    part = np.array(trace["z"], dtype=float) - trace["zmin"]
    shades = np.rint(SHADES * np.clip(part / (trace["zmax"] - trace["zmin"]), 0.0, 1.0))
    for shade in np.unique(shades[np.isfinite(shades)]):
        cells = (
            f"M{xs[j]:.0f} {ys[i]:.0f}H{xs[j + 1]:.0f}V{ys[i + 1]:.0f}H{xs[j]:.0f}z"
            for i, j in np.argwhere(shades == shade)
        )
        yield f'<path fill="{_shade(trace, shade / SHADES)}" d="{"".join(cells)}"/>'


def _edges(places: Array) -> Array:
    """The edges of cells about their middles."""
    middles = (places[1:] + places[:-1]) / 2
    return np.concatenate([places[:1], middles, places[-1:]])


def _shade(trace: Trace, part: float) -> str:
    """The colour of a map at a part of its scale."""
    places, colours = zip(*trace["colorscale"], strict=True)
    channels = np.array([list(bytes.fromhex(c[1:])) for c in colours]).T
    return "#" + "".join(f"{round(float(np.interp(part, places, c))):02x}" for c in channels)


def _scale(trace: Trace, right: float, y: Axis) -> Iterator[str]:
    """The colour bar of a map, beside the axes."""
    if trace["type"] != "heatmap":
        return
    x, size = right + 8, (y.start - y.end) / SHADES
    for k in range(SHADES):
        fill, top = _shade(trace, (k + 0.5) / SHADES), y.start - size * (k + 1)
        yield f'<rect x="{x}" y="{top:.1f}" width="10" height="{size:.1f}" fill="{fill}"/>'
    up = Axis(trace["zmin"], trace["zmax"], y.start, y.end, False)
    for place, text in _ticks(trace["colorbar"], up):
        yield f'<text x="{x + 14}" y="{place + 4:.1f}">{text}</text>'


def colour(trace: Trace) -> str:
    """The colour of a trace."""
    return str(trace.get("line", {}).get("color", GREY))


def dashes(trace: Trace) -> str:
    """Its dashes, empty for a solid line."""
    return DASHES.get(trace.get("line", {}).get("dash", ""), "")
