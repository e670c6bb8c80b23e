"""A sweep as text: the runs, errors of each method and step, and the worst points."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from plumbob.engines.box import Side
from plumbob.engines.sweep.sweep import Swept
from plumbob.reports.view.notation import number, relative

MOST = 10  # worst points that are listed of a method and a step


def rows(swept: Swept) -> tuple[dict[str, Any], ...]:
    """Every method with every step, in the order in which they were asked for."""
    return tuple(
        _row(swept, i, j)
        for i in range(len(swept.sweep.methods))
        for j in range(len(swept.sweep.steps))
    )


def _row(swept: Swept, i: int, j: int) -> dict[str, Any]:
    """The errors of a method at a step over all points."""
    method = swept.sweep.methods[i]
    step = swept.sweep.steps[j]
    errors = swept.errors[i, j].ravel()
    there = errors[~np.isnan(errors)]
    median, ninety, largest = (
        float(np.quantile(there, q, method="lower")) if len(there) else np.nan
        for q in (0.5, 0.9, 1.0)
    )
    worst = tuple(
        _worst(swept, point, error, method.name, step)
        for point, error in swept.worst(i, j, MOST)
    )
    return {
        "method": method.name,
        "step": step,  # [s], or relative tolerance
        "control": method.control,  # what the step means
        "median": median,  # relative error, of the runs that have one
        "ninety": ninety,  # that nine runs of ten do not exceed
        "largest": largest,
        "diverged": int(np.isinf(there).sum()),  # runs
        "without": int(np.isnan(errors).sum()),  # points: no exact answer, or no model
        "worst": worst,
    }


def _worst(swept: Swept, point: int, error: float, method: str, step: float) -> dict[str, Any]:
    """A point with a large error, infinite where the run diverged, and what repeats it."""
    place = swept.sweep.place(point)
    varied = {s.name: s.at(x) for s, x in zip(swept.sweep.box.sides, place, strict=True)}
    again = command(swept.sweep.box.scene, method, step, swept.sweep.box.parameters(place))
    return {"parameters": varied, "error": error, "command": again}


def command(scene: str, method: str, step: float, parameters: Mapping[str, Any]) -> str:
    """The command that repeats one run, every parameter to its last bit."""
    words = ["plumbob", "run", scene, method, "--step", repr(step)]
    for name, value in parameters.items():
        words += ["--set", f"{name}={json.dumps(value)}"]
    return shlex.join(words)


def size(error: float) -> str:
    """A relative error, or that the run diverged."""
    return "diverged" if np.isinf(error) else relative(error)


def place(parameters: Mapping[str, float]) -> str:
    """Varied parameters with their values."""
    return ", ".join(f"{name} {number(value, 5)}" for name, value in parameters.items())


def sides(of: Sequence[Side]) -> str:
    """The varied parameters and their bounds."""
    return " and ".join(f"{s.name} from {number(s.low, 4)} to {number(s.high, 4)}" for s in of)


def words(swept: Swept) -> dict[str, Any]:
    """The sweep as the terminal's lines take it."""
    box = swept.sweep.box
    return {
        "scene": box.scene,
        "sides": sides(box.sides),
        "points": swept.sweep.points,
        "rows": rows(swept),
        "reasons": swept.reasons,
        "size": size,
        "place": place,
    }
