"""A sweep as text: number of runs, errors of each method and step, and the worst points."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from plumbob.engines.box import Side
from plumbob.engines.sweep.sweep import Swept
from plumbob.reports.records.notation import number, relative

LISTED_POINTS = 10  # number of worst points listed for each method and step
LEAST_RUNS = 10  # smallest number of runs of which a tenth is a run or more


def sweep_rows(swept: Swept) -> tuple[dict[str, Any], ...]:
    """Returns the errors of every method at every step, as a row each, in the order that the user
    gave."""
    return tuple(
        _row(swept, i, j)
        for i in range(len(swept.sweep.methods))
        for j in range(len(swept.sweep.steps))
    )


def _row(swept: Swept, i: int, j: int) -> dict[str, Any]:
    """Returns the statistics of the errors over all points, for method `i` at step `j`."""
    method = swept.sweep.methods[i]
    step = swept.sweep.steps[j]
    errors = swept.errors[i, j].ravel()
    known = errors[~np.isnan(errors)]
    median, ninety, largest = (np.nan, np.nan, np.nan)
    if known.size:
        median, ninety, largest = np.quantile(known, (0.5, 0.9, 1.0), method="lower").tolist()
    worst = tuple(
        _worst_point(swept, point, error, method.name, step)
        for point, error in swept.worst(i, j, LISTED_POINTS)
    )
    return {
        "method": method.name,
        "step": step,  # [s], or relative tolerance
        "control": method.control,  # what the step means
        "median": median,  # median relative error of the runs with an error
        "ninety": ninety,  # relative error that nine of ten runs do not exceed
        "largest": largest,
        "diverged": int(np.isinf(known).sum()),  # number of runs that diverged
        "without": int(
            np.isnan(errors).sum()
        ),  # number of points without exact answer or model
        "worst": worst,
    }


def _worst_point(
    swept: Swept, point: int, error: float, method: str, step: float
) -> dict[str, Any]:
    """Returns a point with a large error: its varied parameters, its relative error (infinite if
    the run diverged), and the command that repeats the run."""
    box = swept.sweep.box
    position = swept.sweep.place(point)
    varied = {side.name: side.at(x) for side, x in zip(box.sides, position, strict=True)}
    repeat = repeat_command(box.scene, method, step, box.parameters(position))
    return {"parameters": varied, "error": error, "command": repeat}


def repeat_command(scene: str, method: str, step: float, parameters: Mapping[str, Any]) -> str:
    """Returns the command that repeats one run, with every parameter to its last bit."""
    terminal_values = ["plumbob", "run", scene, method, "--step", repr(step)]
    for name, value in parameters.items():
        terminal_values += ["--set", f"{name}={json.dumps(value)}"]
    return shlex.join(terminal_values)


def error_text(error: float) -> str:
    """Returns a relative error as text; "diverged" if it is infinite."""
    return "diverged" if np.isinf(error) else relative(error)


def tenth_text(row: Mapping[str, Any], points: int) -> str:
    """Returns the relative error that nine of ten runs of a row do not exceed, as text. It is empty
    if fewer than LEAST_RUNS of the `points` have an error, or if it reads as the largest error."""
    text = error_text(row["ninety"])
    enough = points - row["without"] >= LEAST_RUNS
    return text if enough and text != error_text(row["largest"]) else ""


def point_text(parameters: Mapping[str, float]) -> str:
    """Returns the varied parameters and their values as text."""
    return ", ".join(f"{name} {number(value, 5)}" for name, value in parameters.items())


def sides_text(varied: Sequence[Side]) -> str:
    """Returns the varied parameters and their bounds as text."""
    ranges = [f"{s.name} from {number(s.low, 4)} to {number(s.high, 4)}" for s in varied]
    return " and ".join(ranges)


def terminal_values(swept: Swept) -> dict[str, Any]:
    """Returns the values of the template that writes a sweep to the terminal. Three of them are
    functions that the template calls: "size" formats an error, "place" a point of the grid, and
    "tenth" the error that nine of ten runs do not exceed."""
    box = swept.sweep.box
    return {
        "scene": box.scene,
        "sides": sides_text(box.sides),
        "points": swept.sweep.points,
        "rows": sweep_rows(swept),
        "reasons": swept.reasons,
        "size": error_text,
        "place": point_text,
        "tenth": partial(tenth_text, points=swept.sweep.points),
    }
