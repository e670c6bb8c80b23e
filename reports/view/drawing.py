"""A whole figure as an SVG file: curves, bars and maps, with axes and names, on light and dark."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
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
LEFT, RIGHT, TOP, BOTTOM = 64, 18, 10, 40  # margins [px]
LETTER, ROW, SAMPLE = 7.4, 17, 20  # [px]: a letter at most, a line of names, a piece of a curve
NARROW = 0.8  # of its width: a picture that is shown smaller has larger letters
NAMES, LONGEST = 6, 24  # that stand at their lines' ends: so many, of so many letters
SHADES = 16
FINE = 3.0  # tenths of a pixel by which a curve may be off
STYLE = (
    "<style>text{font:11px Arial,sans-serif;fill:#4d565f}.m{text-anchor:middle}.e{text-anchor:end}"
    ".a{stroke:#b4bcc4}.g{stroke:#e6e9ec}@media(prefers-color-scheme:dark){text{fill:#b4bec7}"
    ".a{stroke:#4b565f}.g{stroke:#2a3137}}@media(max-width:%dpx){text{font-size:14px}}</style>"
)
# Marks by plotly's names: corners, the direction of the first one in half turns, and how far the
# middles of the sides are from the centre, where these are no straight ones.
GLYPHS: Mapping[str, tuple[int, float, float]] = MappingProxyType(
    {
        "square": (4, 0.25, 0.0),
        "diamond": (4, 0.0, 0.0),
        "triangle-up": (3, -0.5, 0.0),
        "triangle-down": (3, 0.5, 0.0),
        "x": (4, 0.25, 0.35),
        "star": (4, 0.0, 0.45),
    }
)
HEXAGON = (6, 0.0, 0.0)
DASHES = MappingProxyType({"dash": "6 4", "dot": "2 3", "dashdot": "6 3 2 3"})

Axes = Mapping[str, Axis]  # by their letters


@dataclass(frozen=True)
class Frame:
    """Where the axes of a drawing are [px]."""

    width: float
    height: float
    left: float
    right: float
    bottom: float  # from its top
    named: tuple[Trace, ...] = ()  # traces with a name in the legend
    at_ends: bool = False  # which stands at the ends of lines, else below
    ticks: int = 6  # of an axis, at most


@dataclass(frozen=True)
class Drawing:
    """An SVG file and its size [px]."""

    svg: str
    width: int
    height: int


def drawing(figure: Figure, chosen: Sequence[str] = ()) -> Drawing | None:
    """A figure as an SVG file, of curves that belong to methods those of the `chosen` ones, if
    there are any; None where nothing has a place on its axes."""
    traces = shown(figure, chosen)
    frame = _frame(figure, traces)
    if not (inside := plotted(figure.layout, traces, frame)):
        return None
    text = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {frame.width:g} {frame.height:g}">'
        f"{STYLE % (NARROW * frame.width)}{inside}</svg>"
    )
    return Drawing(text, round(frame.width), round(frame.height))


def plotted(layout: Layout, traces: Sequence[Trace], frame: Frame) -> str:
    """Axes, traces and their names in a frame, as elements of SVG; empty where nothing has a place
    on the axes. Between the axes units are tenths of a pixel."""
    axes = _both(layout, frame, traces)
    if not {"x", "y"} <= set(axes):
        return ""
    marks = "".join(part for trace in traces for part in _marks(trace, axes, traces))
    marks += "".join(_line(of, axes) for of in layout.get("shapes", ()))
    names = [*(_at_ends(axes, frame) if frame.at_ends else _below(frame))]
    if traces[0]["type"] == "heatmap":
        names += _scale(traces[0], frame)
    box = frame.left, TOP, frame.width - frame.left - frame.right, frame.bottom - TOP
    x, y, width, height = (f"{v:g}" for v in box)
    units = " ".join(f"{10 * v:g}" for v in box)
    return (
        f"{''.join(_axes(layout, axes, frame))}"
        f'<svg x="{x}" y="{y}" width="{width}" height="{height}" viewBox="{units}" fill="none" '
        f'stroke-linejoin="round">{marks}</svg>{"".join(names)}'
    )


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
    if not any(t.get("meta") == FRONT for t in kept):
        return kept
    best = front(points, lambda point: point[:2])
    edge = {"x": [x for _, _, x in best], "y": [y for _, y, _ in best]}
    return [{**t, **edge} if t.get("meta") == FRONT else t for t in kept]


def _frame(figure: Figure, traces: Sequence[Trace]) -> Frame:
    """The margins that the labels of a figure need."""
    layout, named = figure.layout, _named(traces, figure.layout)
    names = [str(t["name"]) for t in named]
    square, at_ends = "scaleanchor" in layout["yaxis"], _fit_at_ends(named, layout)
    words = "<br>".join(layout["yaxis"].get("ticktext", ())).split("<br>")
    left = max(LEFT, 24 + LETTER * max(map(len, words)))
    right = float(LEFT if "yaxis2" in layout else RIGHT)
    if at_ends:
        right = SAMPLE + 12 + LETTER * max(map(len, names))
    right += 50 if traces[0]["type"] == "heatmap" else 0
    width, bottom = WIDE if figure.wide else WIDTH, (SQUARE if square else figure.height) - BOTTOM
    if layout.get("barmode") == "stack":
        bottom = TOP + 22 * len(words)
    height = bottom + BOTTOM + ROW * (0 if at_ends else _rows(names, width))
    return Frame(width, height, left, right, bottom, tuple(named), at_ends)


def _fit_at_ends(named: Sequence[Trace], layout: Layout) -> bool:
    """Whether names are few and short enough to stand beside the axes, each at a line's end."""
    if not 0 < len(named) <= NAMES or "scaleanchor" in layout["yaxis"] or "yaxis2" in layout:
        return False
    return all("lines" in t.get("mode", "") and len(t["name"]) <= LONGEST for t in named)


def _values(traces: Sequence[Trace], key: str) -> list[float]:
    """All values of the traces along an axis."""
    found: list[float] = []
    for t in (t for t in traces if key == "x" or t.get("yaxis", "y") == key):
        found += [v for v in t[key[0]] if v is not None]
        if t["type"] == "bar":
            found += [min(t["y"]) - 0.5, max(t["y"]) + 0.5] if key == "y" else [0.0, 100.0]
    return found


def _axis(layout: Layout, values: list[float], ends: tuple[float, float]) -> Axis:
    logarithmic = layout.get("type") == "log"
    places = [math.log10(v) for v in values if v > 0.0] if logarithmic else values
    low, high = layout.get("range") or (min(places, default=0.0), max(places, default=1.0))
    apart = "range" not in layout and "tickvals" not in layout
    margin = (0.04 * (high - low) or 0.5 * abs(high) or 0.5) if apart or high <= low else 0.0
    return Axis(low - margin, high + margin, *ends, logarithmic)


def _both(layout: Layout, frame: Frame, traces: Sequence[Trace]) -> Axes:
    """The axes that have values, by their letters."""
    across, up = (frame.left, frame.width - frame.right), (frame.bottom, TOP)
    ends = (("x", "xaxis", across), ("y", "yaxis", up), ("y2", "yaxis2", up))
    axes = {
        key: _axis(layout.get(name, {}), values, between)
        for key, name, between in ends
        if len(values := _values(traces, key))
    }
    return _one_scale(axes) if "scaleanchor" in layout["yaxis"] else axes


def _one_scale(axes: Axes) -> dict[str, Axis]:
    """The same axes with as many pixels to a unit on both, about their middles."""
    scale = max((a.high - a.low) / abs(a.end - a.start) for a in axes.values())
    changed = {}
    for key, a in axes.items():
        middle, half = (a.low + a.high) / 2, abs(a.end - a.start) * scale / 2
        changed[key] = Axis(middle - half, middle + half, a.start, a.end, a.logarithmic)
    return changed


def _axes(layout: Layout, axes: Axes, frame: Frame) -> Iterator[str]:
    """Lines, ticks and titles of the axes."""
    bottom, end, middle = frame.bottom, frame.width - frame.right, (TOP + frame.bottom) / 2
    xs, ys = (_ticks(layout[f"{k}axis"], axes[k], frame) for k in "xy")
    grid = [f"M{x:.0f} {TOP}V{bottom:g}" for x, _ in xs]
    grid += [f"M{frame.left:g} {y:.0f}H{end:g}" for y, _ in ys]
    yield f'<path class="g" d="{"".join(grid)}"/>'
    for x, text in xs:
        yield f'<text class="m" x="{x:.0f}" y="{bottom + 14:g}">{text}</text>'
    for y, text in ys:
        lines = text.split("&lt;br&gt;")
        for k, line in enumerate(lines):
            at = y + 4 + 13 * (k - (len(lines) - 1) / 2)
            yield f'<text class="e" x="{frame.left - 5:g}" y="{at:.0f}">{line}</text>'
    titles = {name: escape(layout[name]["title"]["text"]) for name in layout if "axis" in name}
    yield f'<path class="a" fill="none" d="M{frame.left:g} {TOP}V{bottom:g}H{end:g}"/>'
    x = (frame.left + end) / 2
    yield f'<text class="m" x="{x:g}" y="{bottom + 31:g}">{titles["xaxis"]}</text>'
    sides = [(13.0, titles["yaxis"])]
    if "y2" in axes:
        sides.append((frame.width - 6.0, titles["yaxis2"]))
        for y, text in axes["y2"].ticks(frame.ticks):
            yield f'<text x="{end + 5:g}" y="{y + 4:.1f}">{text}</text>'
    for x, title in sides:
        turned = f'transform="rotate(-90 {x:g} {middle:g})"'
        yield f'<text class="m" x="{x:g}" y="{middle:g}" {turned}>{title}</text>'


def _ticks(layout: Layout, axis: Axis, frame: Frame) -> list[tuple[float, str]]:
    if "ticktext" not in layout:
        return axis.ticks(frame.ticks)
    places = axis.along(layout["tickvals"]).tolist()
    return list(zip(places, map(escape, layout["ticktext"]), strict=True))


def _marks(trace: Trace, axes: Axes, traces: Sequence[Trace]) -> Iterator[str]:
    """The elements of a trace, in tenths of a pixel."""
    if trace["type"] == "heatmap":
        yield from _map(trace, axes)
        return
    if trace["type"] == "bar":
        yield _bars(trace, axes, traces)
        return
    places, mode = _places(trace, axes), trace.get("mode", "lines")
    if "lines" in mode:
        dash = " ".join(f"{10 * int(n)}" for n in dashes(trace).split())
        more = f' stroke-dasharray="{dash}"' if dash else ""
        more += f' opacity="{trace["opacity"]}"' if "opacity" in trace else ""
        width = 10.0 * trace.get("line", {}).get("width", 1.6)
        path = "".join(_path(_simplified(run)) for run in _runs(places))
        yield f'<path stroke="{colour(trace)}" stroke-width="{width:g}"{more} d="{path}"/>'
    if "markers" in mode:
        yield _dots(trace, places)


def _dots(trace: Trace, places: Array) -> str:
    """The marks of a trace as one path; discs are round ends of lines without length."""
    marker, stroke = trace.get("marker", {}), colour(trace)
    name, size = marker.get("symbol", "circle"), 5.0 * marker.get("size", 6)
    look, shape = f'fill="{stroke}"', "h0"
    if name == "circle":
        look = f'stroke-width="{2 * size:g}" stroke-linecap="round"'
    else:
        shape = _glyph(name.removesuffix("-open"), size)
        look = 'stroke-width="13"' if name.endswith("-open") else look
    dots = "".join(f"M{x:.0f} {y:.0f}{shape}" for x, y in places if math.isfinite(x + y))
    return f'<path stroke="{stroke}" {look} d="{dots}"/>'


def _places(trace: Trace, axes: Axes) -> Array:
    """Places of a trace's points in tenths of a pixel, (n, 2)."""
    up = axes[trace.get("yaxis", "y")]
    return 10.0 * np.column_stack([axes["x"].along(trace["x"]), up.along(trace["y"])])


def _runs(places: Array) -> Iterator[Array]:
    """The parts of a curve between gaps."""
    there = np.isfinite(places).all(axis=1)
    for part in np.split(places, np.flatnonzero(~there)):
        if len(run := part[np.isfinite(part).all(axis=1)]) > 1:
            yield run


def _simplified(places: Array) -> Array:
    """A curve without the points that are on the line from the one before to the one after."""
    for _ in range(4):
        if len(places) < 8:
            break
        before, at, after = (places[k : len(places) - 2 + k][::2] for k in range(3))
        along, aside = after - before, at - before
        off = np.abs(along[:, 0] * aside[:, 1] - along[:, 1] * aside[:, 0])
        kept = np.ones(len(places), dtype=bool)
        kept[1:-1:2] = off > FINE * np.hypot(*along.T) + 1e-9
        places = places[kept]
    return places


def _path(places: Array) -> str:
    """A path through points, in whole numbers and by differences, which are short."""
    numbers = np.rint(places).astype(int)
    rest = " ".join(map(str, np.diff(numbers, axis=0).ravel().tolist())).replace(" -", "-")
    return f"M{numbers[0, 0]} {numbers[0, 1]}l{rest}"


def _glyph(name: str, radius: float) -> str:
    """A mark of a radius as a path from its point."""
    if name == "circle":
        r = f"{radius:g}"
        turn = f"a{r} {r} 0 1 0"
        return f"m-{r} 0{turn} {2 * radius:g} 0{turn}-{2 * radius:g} 0z"
    corners, first, inner = GLYPHS.get(name, HEXAGON)
    places = np.arange(0, 2 * corners, 1 if inner else 2)
    angles, sizes = np.pi * (first + places / corners), np.where(places % 2, inner, 1.0)
    points = 1.2 * radius * sizes * [np.cos(angles), np.sin(angles)]
    return f"m{_path(points.T)[1:]}z"


def _bars(trace: Trace, axes: Axes, traces: Sequence[Trace]) -> str:
    """Pieces of stacked bars, after those of the traces before."""
    before = traces[: traces.index(trace)]
    path = ""
    for row, value in zip(trace["y"], trace["x"], strict=True):
        start = sum(v for t in before for r, v in zip(t["y"], t["x"], strict=True) if r == row)
        left, right = (10.0 * axes["x"].at(v) for v in (start, start + value))
        top, low = (10.0 * axes["y"].at(row + side) for side in (0.38, -0.38))
        path += f"M{left:.0f} {top:.0f}H{right:.0f}V{low:.0f}H{left:.0f}z"
    return f'<path fill="{colour(trace)}" d="{path}"/>'


def _map(trace: Trace, axes: Axes) -> Iterator[str]:
    """The cells of a map, those of one shade as one path, in which a row's are joined."""
    xs, ys = (10.0 * _edges(axes[k].along(trace[k])) for k in "xy")
    zero, full = _limits(trace)
    part = (np.array(trace["z"], dtype=float) - zero) / (full - zero)
    shades = np.rint(SHADES * np.clip(part, 0.0, 1.0))
    for shade in np.unique(shades[np.isfinite(shades)]):
        edges = np.diff(np.pad(shades == shade, ((0, 0), (1, 1))).astype(int), axis=1)
        first, last = (np.argwhere(edges == sign) for sign in (1, -1))  # of cells beside each other
        cells = (
            f"M{xs[j]:.0f} {ys[i]:.0f}H{xs[k]:.0f}V{ys[i + 1]:.0f}H{xs[j]:.0f}z"
            for (i, j), (_, k) in zip(first, last, strict=True)
        )
        yield f'<path fill="{_shade(trace, shade / SHADES)}" d="{"".join(cells)}"/>'


def _edges(places: Array) -> Array:
    """The edges of cells about their middles."""
    middles = (places[1:] + places[:-1]) / 2
    return np.concatenate([places[:1], middles, places[-1:]])


def _shade(trace: Trace, part: float) -> str:
    """The colour of a map at a part of its scale."""
    places, colours = zip(*trace["colorscale"], strict=True)
    channels = [[int(c[k : k + 2], 16) for c in colours] for k in (1, 3, 5)]
    return "#" + "".join(f"{round(float(np.interp(part, places, c))):02x}" for c in channels)


def _scale(trace: Trace, frame: Frame) -> Iterator[str]:
    """The colour bar of a map, beside the axes."""
    x, bar, low, high = frame.width - frame.right + 8.0, trace["colorbar"], *_limits(trace)
    up = Axis(low, high, frame.bottom, TOP, False)
    size = (frame.bottom - TOP) / SHADES
    for k in range(SHADES):
        fill, y = _shade(trace, (k + 0.5) / SHADES), frame.bottom - size * (k + 1)
        yield f'<rect x="{x:g}" y="{y:.1f}" width="10" height="{size:.1f}" fill="{fill}"/>'
    for y, text in _ticks(bar, up, frame):
        yield f'<text x="{x + 14:g}" y="{y + 4:.1f}">{text}</text>'


def _limits(trace: Trace) -> tuple[float, float]:
    return float(trace["zmin"]), float(trace["zmax"])


def _line(of: Layout, axes: Axes) -> str:
    """A straight line across the height of a plot, or a part of it."""
    x, up = 10.0 * axes["x"].at(of["x0"]), axes["y"]
    low, high = (10.0 * (up.start + of[k] * (up.end - up.start)) for k in ("y0", "y1"))
    stroke = f'stroke="{of["line"]["color"]}" stroke-width="20" stroke-dasharray="20 30"'
    return f'<path {stroke} d="M{x:.0f} {low:.0f}V{high:.0f}"/>'


def _named(traces: Sequence[Trace], layout: Layout) -> list[Trace]:
    """The traces that have a name in a legend, one a name: that with marks, if there is one."""
    if not layout.get("showlegend") and not any("meta" in t for t in traces):
        return []
    named = [t for t in traces if t.get("name") and t.get("showlegend", True)]
    by_name = {t["name"]: t for t in named}
    by_name |= {t["name"]: t for t in named if "markers" in t.get("mode", "")}
    return list(by_name.values())


def _flow(names: Sequence[str], width: float) -> Iterator[tuple[str, float, int]]:
    """Names with their places [px] and rows in a legend of a width."""
    x, row = 8.0, 0
    for name in names:
        size = SAMPLE + 22 + LETTER * len(name)
        if x > 8.0 and x + size > width:
            x, row = 8.0, row + 1
        yield name, x, row
        x += size


def _rows(names: Sequence[str], width: float) -> int:
    return max((row for _, _, row in _flow(names, width)), default=-1) + 1


def _below(frame: Frame) -> Iterator[str]:
    """A legend below the axes."""
    places = _flow([str(t["name"]) for t in frame.named], frame.width)
    for trace, (_, x, row) in zip(frame.named, places, strict=True):
        yield _name(trace, x, frame.bottom + BOTTOM + ROW * row + 8)


def _at_ends(axes: Axes, frame: Frame) -> Iterator[str]:
    """Names beside the axes, at the heights of their curves' right ends, apart from each other."""
    ends = []
    for trace in frame.named:
        places = _places(trace, axes) / 10.0
        there = places[np.isfinite(places).all(axis=1)]
        ends.append((float(there[np.argmax(there[:, 0]), 1]) if len(there) else TOP, trace))
    ends.sort(key=lambda end: end[0])
    place, heights = TOP + 4.0 - ROW, []
    for k, (end, _) in enumerate(ends):
        left = frame.bottom - ROW * (len(ends) - 1 - k)
        place = min(max(end, place + ROW), left)
        heights.append(place)
    for y, (_, trace) in zip(heights, ends, strict=True):
        yield _name(trace, frame.width - frame.right + 6.0, y)


def _name(trace: Trace, x: float, y: float) -> str:
    """A piece of a curve and its name, at a place [px]."""
    dash = f' stroke-dasharray="{dashes(trace)}"' if dashes(trace) else ""
    width, line = 9 if trace["type"] == "bar" else 2.5, f"M{x:.0f} {y:.1f}h{SAMPLE}"
    if "lines" not in trace.get("mode", "lines"):  # a mark: a round end without a line
        width, line = 6, f"M{x + SAMPLE / 2:.0f} {y:.1f}h0"
        dash = ' stroke-linecap="round"'
    return (
        f'<path stroke="{colour(trace)}" stroke-width="{width}"{dash} d="{line}"/>'
        f'<text x="{x + SAMPLE + 4:.0f}" y="{y + 4:.1f}">{escape(str(trace["name"]))}</text>'
    )


def colour(trace: Trace) -> str:
    """The colour of a trace."""
    return str(trace.get("line", {}).get("color") or trace.get("marker", {}).get("color") or GREY)


def dashes(trace: Trace) -> str:
    """Its dashes, empty for a solid line."""
    return DASHES.get(trace.get("line", {}).get("dash", ""), "")
