"""The page of a sweep: maps of the relative error over the parameters, and the worst points."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.box import Side
from plumbob.engines.study.provenance import Provenance
from plumbob.engines.sweep.sweep import Swept
from plumbob.reports.view.axis import Axis
from plumbob.reports.view.content import Figure, Table
from plumbob.reports.view.notation import plural
from plumbob.reports.view.notation import step as step_text
from plumbob.reports.view.page import filled, written
from plumbob.reports.view.plotly_figure import (
    ZERO,
    curve,
    figure,
    linear,
    logarithmic,
    positive,
    rounded,
)
from plumbob.reports.view.sweep.text import place, rows, sides, size
from plumbob.reports.view.tables import paragraphs, table

MOST = 160  # columns and rows of a map: the worst of some neighbours stands for them
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
# Viridis, which is read alike by those who do not tell red from green.
SCALE = tuple(enumerate(("#440154", "#3b528b", "#21918c", "#5ec962", "#fde725")))


def write_sweep_page(swept: Swept, folder: Path, provenance: Provenance, key: str) -> Path:
    """Write `sweep-SCENE-KEY.html` into `folder` and return its path. Raises OSError where the
    folder cannot be written."""
    name = f"sweep-{swept.sweep.box.scene.replace('/', '-')}-{key[:8]}.html"
    return written(render(swept, provenance), folder, name)


def render(swept: Swept, provenance: Provenance) -> str:
    """The page of a sweep as HTML, in one file."""
    of, runs = swept.sweep, math.prod(swept.errors.shape)
    return filled(
        "sweep.html.jinja",
        title=f"{of.box.scene} over {' and '.join(s.name for s in of.box.sides)}",
        lead=f"{plural(runs, 'run')}: {sides(of.box.sides)} (SI units, radians), "
        f"{plural(of.points, 'point')} in all"
        + "".join(f", {name} {value}" for name, value in of.box.changes)
        + ". Every run is held against the exact answer for its own parameters; errors are "
        "relative to the characteristic scale of what the scene is about.",
        summary=_summary(swept),
        figures=figures(swept),
        worst=_worst(swept),
        reasons=[f"{plural(count, 'run')}: {why}" for why, count in swept.reasons.items()],
        command=provenance.command,
        date=provenance.date,
        versions=", ".join(f"{name} {value}" for name, value in provenance.versions.items()),
    )


def _summary(swept: Swept) -> Table:
    return table("sweep", rows=rows(swept), size=size, place=place)


def _worst(swept: Swept) -> tuple[Table, ...]:
    written = rows(swept)
    return tuple(table("sweep_worst", of=r, size=size, place=place) for r in written if r["worst"])


def figures(swept: Swept) -> tuple[Figure, ...]:
    """A map each of the first two sides where there are two or more, and curves over every other
    side; where there is one side alone, curves over that."""
    axes = swept.sweep.box.sides
    if len(axes) == 1:
        return (_curves(swept, 0),)
    finite = swept.errors[np.isfinite(swept.errors)]
    low, high = (math.log10(max(float(f(finite)), ZERO)) for f in (np.min, np.max))
    maps = tuple(
        _map(swept, i, j, low, high)
        for i in range(len(swept.sweep.methods))
        for j in range(len(swept.sweep.steps))
    )
    return (*maps, *(_curves(swept, k) for k in range(2, len(axes))))


def _map(swept: Swept, i: int, j: int, low: float, high: float) -> Figure:
    of, (x, y) = swept.sweep, swept.sweep.box.sides[:2]
    errors = swept.errors[i, j]
    flat = _largest(errors.reshape(*errors.shape[:2], -1), (2,))
    xs, ys = x.values(of.counts[0]), y.values(of.counts[1])
    across, along = -(-len(xs) // MOST), -(-len(ys) // MOST)
    flat = _blocks(_blocks(flat, across).T, along)  # rows are values of y
    z = np.log10(np.maximum(flat, ZERO))
    shown = [rounded(np.where(np.isposinf(line), high + 1.0, line)) for line in z]
    trace = {
        "type": "heatmap",
        "x": rounded(xs[::across]),
        "y": rounded(ys[::along]),
        "z": shown,
        "zmin": low,
        "zmax": max(high, low + 0.1),
        "colorscale": [[k / 4, shade] for k, shade in SCALE],
        "colorbar": {"title": {"text": "error"}, **_ticks(low, max(high, low + 0.1))},
        "hovertemplate": f"{x.name} %{{x}}, {y.name} %{{y}}: 10^%{{z:.2f}}<extra></extra>",
        "name": of.methods[i].name,
    }
    name = f"{of.methods[i].name} at {step_text(of.steps[j], of.methods[i].control)}"
    more = "; the worst over what else is varied" if len(of.counts) > 2 else ""
    caption = f"Relative error over {x.name} and {y.name}{more}; all maps have one scale."
    return figure(name, caption, [trace], _axis(x), _axis(y), height=420)


def _curves(swept: Swept, side: int) -> Figure:
    of, axis = swept.sweep, swept.sweep.box.sides[side]
    xs, traces = axis.values(of.counts[side]), []
    for i, method in enumerate(of.methods):
        for j, step in enumerate(of.steps):
            errors = swept.errors[i, j]
            others = tuple(k for k in range(errors.ndim) if k != side)
            largest = _largest(errors, others)
            name = f"{method.name}, {step_text(step, method.control)}"
            colour = COLOURS[(i * len(of.steps) + j) % len(COLOURS)]
            traces.append(
                curve(
                    xs,
                    np.where(np.isfinite(largest), positive(largest), np.nan),
                    colour=colour,
                    name=name,
                    marks=len(xs) <= 60,
                )
            )
    more = ", the worst over what else is varied" if len(of.counts) > 1 else ""
    return figure(
        f"Error over {axis.name}",
        f"Relative error{more}. A gap: a run diverged, or has no exact answer.",
        traces,
        _axis(axis),
        logarithmic("relative error [1]"),
        legend=True,
        wide=True,
    )


def _largest(errors: Array, axes: tuple[int, ...]) -> Array:
    """The largest over some axes of those that are numbers; NaN where there is none."""
    if not axes:
        return errors
    none = np.isnan(errors).all(axis=axes)
    largest = np.where(np.isnan(errors), -np.inf, errors).max(axis=axes)
    return np.where(none, np.nan, largest)


def _blocks(errors: Array, size: int) -> Array:
    """The largest of every `size` rows, shape (n, m) to (ceil(n / size), m)."""
    missing = -len(errors) % size
    padded = np.vstack([errors, np.full((missing, errors.shape[1]), np.nan)])
    return _largest(padded.reshape(-1, size, errors.shape[1]), (1,))


def _axis(side: Side) -> dict[str, object]:
    by_unit = (line.split(": ") for line in paragraphs("units"))
    units = {name: f" [{unit}]" for unit, names in by_unit for name in names.split(", ")}
    title = side.name + units.get(side.name, "")
    return dict(logarithmic(title) if side.logarithmic else linear(title))


def _ticks(low: float, high: float) -> dict[str, object]:
    """Labels of a colour bar in errors, where the scale is in powers of ten."""
    places, texts = zip(*Axis(low, high, low, high, True).ticks(8), strict=True)
    return {"tickvals": places, "ticktext": texts}
