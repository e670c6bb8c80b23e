"""A sweep as columns: every point with its parameters, by method and step."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from plumbob.engines.sweep.sweep import Swept
from plumbob.reports.columns.columns import ColumnMeaning, Columns, columns_of


def point_columns(swept: Swept) -> Columns:
    """Returns a row for each method at each step at each point, with a column for each varied
    parameter."""
    sides = swept.sweep.box.sides
    meaning = ColumnMeaning("number", "SI", "value of the varied parameter")
    return columns_of("points", _rows(swept), {side.name: meaning for side in sides})


def _rows(swept: Swept) -> Iterator[dict[str, Any]]:
    """Yields the rows in the order of the points."""
    asked = swept.sweep
    errors = swept.errors.reshape(len(asked.methods), len(asked.steps), asked.points)
    for point in range(asked.points):
        place = asked.place(point)
        varied = {side.name: side.at(x) for side, x in zip(asked.box.sides, place, strict=True)}
        for i, method in enumerate(asked.methods):
            for j, step in enumerate(asked.steps):
                error = float(errors[i, j, point])
                yield {
                    "scene": asked.box.scene,
                    "point": point,
                    "method": method.name,
                    "step": step,
                    "error": error,
                    "status": _status(error),
                    **varied,
                }


def _status(error: float) -> str:
    """Returns what an error says of its run."""
    if math.isnan(error):
        return "none"
    return "diverged" if math.isinf(error) else "done"
