"""The page of a sweep: maps of the relative error over the parameters, and the worst points."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.box import Side
from plumbob.engines.study.provenance import Provenance
from plumbob.engines.sweep.sweep import Sweep, Swept
from plumbob.reports.view import tables
from plumbob.reports.view.axis import Axis
from plumbob.reports.view.content import Figure, Layout
from plumbob.reports.view.page import filled, written
from plumbob.reports.view.plotly_figure import ZERO, linear, logarithmic
from plumbob.reports.view.sweep.text import place, rows, sides, size

MOST = 160  # most columns and rows of a map: beyond, a cell shows the worst of several points
# Viridis can be read with red-green colour blindness.
SHADES = ("#440154", "#3b528b", "#21918c", "#5ec962", "#fde725")


def page_name(sweep: Sweep, key: str) -> str:
    """Returns the file name of the page of a sweep; `key` identifies the sweep in its store."""
    return f"sweep-{sweep.box.scene.replace('/', '-')}-{key[:8]}.html"


def write_sweep_page(swept: Swept, folder: Path, provenance: Provenance, key: str) -> Path:
    """Writes `sweep-SCENE-KEY.html` into `folder` and returns its path; raises OSError if the
    folder cannot be written."""
    return written(render(swept, provenance), folder, page_name(swept.sweep, key))


def render(swept: Swept, provenance: Provenance) -> str:
    """Returns the page of a sweep as one HTML file."""
    every = rows(swept)
    words = {"size": size, "place": place}
    return filled(
        "sweep.html.jinja",
        of=swept.sweep,
        runs=swept.errors.size,
        sides=sides(swept.sweep.box.sides),
        summary=tables.table("sweep", rows=every, **words),
        figures=figures(swept),
        worst=[tables.table("sweep_worst", of=row, **words) for row in every if row["worst"]],
        reasons=swept.reasons,
        provenance=provenance,
    )


def figures(swept: Swept) -> tuple[Figure, ...]:
    """Returns the figures of a sweep. If two or more parameters vary, each method and step has a
    map over the first two, and every further parameter has curves. If one parameter varies, it has
    curves."""
    of = swept.sweep
    finite = swept.errors[np.isfinite(swept.errors)]
    ends = (finite.min(), finite.max()) if finite.size else (ZERO, 1.0)
    low, high = (math.log10(max(float(end), ZERO)) for end in ends)
    high = max(high, low + 0.1)
    places, texts = zip(*Axis(low, high, low, high, True).ticks(8), strict=True)
    plane = len(of.box.sides) > 1
    return tables.figures(
        "sweep",
        sides=of.box.sides,
        axes=[_axis(side) for side in of.box.sides],
        maps=list(_maps(swept)) if plane else [],
        low=low,
        high=high,
        shades=[(k / 4, shade) for k, shade in enumerate(SHADES)],
        bar={"title": {"text": "error"}, "tickvals": places, "ticktext": texts},
        curves=[_curves(swept, k) for k in range(2 * plane, len(of.box.sides))],
    )


def _maps(swept: Swept) -> Iterator[tuple[str, float, str, Array, Array, Array]]:
    """Yields a map over the first two parameters for each method and step: the name of the method,
    the step, its kind ("step" or "tolerance"), the values of both parameters, and the base-10
    logarithms of the largest relative errors, shape (y, x)."""
    of = swept.sweep
    xs, ys = (side.values(n) for side, n in zip(of.box.sides[:2], of.counts, strict=False))
    across, along = (np.arange(0, len(v), -(-len(v) // MOST)) for v in (xs, ys))
    for (i, method), (j, step) in product(enumerate(of.methods), enumerate(of.steps)):
        errors = swept.errors[i, j]
        worst = np.fmax.reduce(errors.reshape(*errors.shape[:2], -1), axis=2)
        worst = np.fmax.reduceat(np.fmax.reduceat(worst, across), along, axis=1)
        powers = np.log10(np.maximum(worst.T, ZERO))
        yield method.name, step, method.control, xs[across], ys[along], powers


def _curves(swept: Swept, side: int) -> dict[str, Any]:
    """Returns the largest relative errors over the values of parameter number `side`, as one line
    for each method and step."""
    of = swept.sweep
    axes = tuple(k for k in range(2, swept.errors.ndim) if k != side + 2)
    largest = np.fmax.reduce(swept.errors, axis=axes)
    lines = [
        (method.name, step, method.control, largest[i, j])
        for (i, method), (j, step) in product(enumerate(of.methods), enumerate(of.steps))
    ]
    return {"side": side, "places": of.box.sides[side].values(of.counts[side]), "lines": lines}


def _axis(side: Side) -> Layout:
    """Returns the axis of a varied parameter, titled with its name and unit."""
    by_unit = (line.split(": ") for line in tables.paragraphs("units"))
    units = {name: f" [{unit}]" for unit, names in by_unit for name in names.split(", ")}
    title = side.name + units.get(side.name, "")
    return logarithmic(title) if side.logarithmic else linear(title)
