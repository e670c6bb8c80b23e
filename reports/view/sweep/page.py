"""The page of a sweep: maps of the relative error over the parameters, and the worst points."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array
from plumbob.engines.box import Side
from plumbob.engines.study.provenance import Provenance
from plumbob.engines.sweep.sweep import Sweep, Swept
from plumbob.reports.view import tables
from plumbob.reports.view.axis import Axis
from plumbob.reports.view.content import Figure, PlotlyLayout
from plumbob.reports.view.page import fill_page, write_file
from plumbob.reports.view.plotly_figure import ZERO, linear, logarithmic
from plumbob.reports.view.sweep.text import (
    error_text,
    point_text,
    sides_text,
    sweep_rows,
    tenth_text,
)
from plumbob.reports.view.units import parameter_units

# most columns and rows of a map; a cell shows the worst of several points
MAX_MAP_CELLS = 160
# Viridis can be read with red-green colour blindness.
VIRIDIS = ("#440154", "#3b528b", "#21918c", "#5ec962", "#fde725")


def page_name(sweep: Sweep, key: str) -> str:
    """Returns the file name of the page of a sweep; `key` identifies the sweep in its store."""
    return f"sweep-{sweep.box.scene.replace('/', '-')}-{key[:8]}.html"


def write_sweep_page(swept: Swept, folder: Path, provenance: Provenance, key: str) -> Path:
    """Writes `sweep-SCENE-KEY.html` into `folder` and returns its path; raises OSError if the
    folder cannot be written."""
    return write_file(render(swept, provenance), folder, page_name(swept.sweep, key))


def render(swept: Swept, provenance: Provenance) -> str:
    """Returns the page of a sweep as one HTML file."""
    swept_rows = sweep_rows(swept)
    words = {
        "size": error_text,
        "place": point_text,
        "tenth": partial(tenth_text, points=swept.sweep.points),
    }
    with_worst = [row for row in swept_rows if row["worst"]]
    return fill_page(
        "sweep.html.jinja",
        of=swept.sweep,
        runs=swept.errors.size,
        sides=sides_text(swept.sweep.box.sides),
        summary=tables.table("sweep", rows=swept_rows, **words),
        figures=sweep_figures(swept),
        worst=[tables.table("sweep_worst", of=row, **words) for row in with_worst],
        reasons=swept.reasons,
        provenance=provenance,
    )


def sweep_figures(swept: Swept) -> tuple[Figure, ...]:
    """Returns the figures of a sweep. If two or more parameters vary, each method and step has a
    map over the first two, and every further parameter has curves. If one parameter varies, it has
    curves."""
    sides_text = swept.sweep.box.sides
    finite = swept.errors[np.isfinite(swept.errors)]
    ends = (finite.min(), finite.max()) if finite.size else (ZERO, 1.0)
    low, high = (math.log10(max(float(end), ZERO)) for end in ends)
    high = max(high, low + 0.1)
    tick_values, tick_texts = zip(*Axis(low, high, low, high, True).ticks(8), strict=True)
    has_maps = len(sides_text) > 1
    first_with_curves = 2 if has_maps else 0
    return tables.figures(
        "sweep",
        sides=sides_text,
        axes=[_axis(side) for side in sides_text],
        maps=list(_maps(swept)) if has_maps else [],
        low=low,
        high=high,
        shades=[(k / 4, shade) for k, shade in enumerate(VIRIDIS)],
        bar={"title": {"text": "error"}, "tickvals": tick_values, "ticktext": tick_texts},
        curves=[_curves(swept, k) for k in range(first_with_curves, len(sides_text))],
    )


def _maps(swept: Swept) -> Iterator[tuple[str, float, str, Array, Array, Array]]:
    """Yields a map over the first two parameters for each method and step: the name of the method,
    the step, its kind ("step" or "tolerance"), the values of both parameters, and the base-10
    logarithms of the largest relative errors, shape (y, x)."""
    sweep = swept.sweep
    first, second = sweep.box.sides[:2]
    xs = first.values(sweep.counts[0])
    ys = second.values(sweep.counts[1])
    columns = _cell_starts(len(xs))
    rows_of_map = _cell_starts(len(ys))
    for (i, method), (j, step) in product(enumerate(sweep.methods), enumerate(sweep.steps)):
        errors = swept.errors[i, j]
        # the worst over all further parameters, then over the points of each cell
        worst = np.fmax.reduce(errors.reshape(*errors.shape[:2], -1), axis=2)
        worst = np.fmax.reduceat(worst, columns)
        worst = np.fmax.reduceat(worst, rows_of_map, axis=1)
        powers = np.log10(np.maximum(worst.T, ZERO))
        yield method.name, step, method.control, xs[columns], ys[rows_of_map], powers


def _cell_starts(count: int) -> npt.NDArray[np.intp]:
    """Returns the indices at which the cells of a map begin, if `count` points are divided into at
    most `MOST` cells of equal size."""
    points_per_cell = -(-count // MAX_MAP_CELLS)
    return np.arange(0, count, points_per_cell)


def _curves(swept: Swept, side: int) -> dict[str, Any]:
    """Returns one line for each method and step: the relative error as a function of parameter
    number `side`, the largest for all values of the other parameters."""
    sweep = swept.sweep
    # The axes of the errors are the method, the step, and then the parameters.
    other_axes = tuple(k for k in range(2, swept.errors.ndim) if k != side + 2)
    largest = np.fmax.reduce(swept.errors, axis=other_axes)
    pairs = product(enumerate(sweep.methods), enumerate(sweep.steps))
    lines = [
        (method.name, step, method.control, largest[i, j]) for (i, method), (j, step) in pairs
    ]
    values = sweep.box.sides[side].values(sweep.counts[side])
    return {"side": side, "places": values, "lines": lines}


def _axis(side: Side) -> PlotlyLayout:
    """Returns the axis of a varied parameter, titled with its name and unit."""
    unit = parameter_units().get(side.name)
    title = f"{side.name} [{unit}]" if unit else side.name
    return logarithmic(title) if side.logarithmic else linear(title)
