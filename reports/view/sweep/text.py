"""A sweep as text: the runs, errors of each method and step, and the worst points."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.engines.box import Side
from plumbob.engines.sweep.sweep import Swept
from plumbob.reports.view.notation import number, relative
from plumbob.reports.view.tables import lines as written

MOST = 10  # worst points that are listed of a method and a step


@dataclass(frozen=True)
class Worst:
    """A point with a large error, and the command that repeats it."""

    parameters: Mapping[str, float]  # the varied ones
    error: float  # relative; infinite where the run diverged
    command: str


@dataclass(frozen=True)
class Row:
    """The errors of a method at a step over all points."""

    method: str
    step: float  # [s], or relative tolerance
    control: str  # what the step means
    median: float  # relative error, of the runs that have one
    ninety: float  # that nine runs of ten do not exceed
    largest: float
    diverged: int  # runs
    without: int  # points without an error: no exact answer, or no model
    worst: tuple[Worst, ...]


def rows(swept: Swept) -> tuple[Row, ...]:
    """Every method with every step, in the order in which they were asked for."""
    return tuple(
        _row(swept, i, j)
        for i in range(len(swept.sweep.methods))
        for j in range(len(swept.sweep.steps))
    )


def _row(swept: Swept, i: int, j: int) -> Row:
    method, step = swept.sweep.methods[i], swept.sweep.steps[j]
    errors = swept.errors[i, j].ravel()
    there = errors[~np.isnan(errors)]
    median, ninety, largest = (
        float(np.quantile(there, q, method="lower")) if len(there) else np.nan
        for q in (0.5, 0.9, 1.0)
    )
    worst = tuple(
        _worst(swept, point, error, method.name, step) for point, error in swept.worst(i, j, MOST)
    )
    return Row(
        method.name,
        step,
        method.control,
        median,
        ninety,
        largest,
        int(np.isinf(there).sum()),
        int(np.isnan(errors).sum()),
        worst,
    )


def _worst(swept: Swept, point: int, error: float, method: str, step: float) -> Worst:
    place = swept.sweep.place(point)
    varied = {s.name: s.at(x) for s, x in zip(swept.sweep.box.sides, place, strict=True)}
    return Worst(
        varied,
        error,
        command(swept.sweep.box.scene, method, step, swept.sweep.box.parameters(place)),
    )


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


def lines(swept: Swept) -> list[str]:
    """The sweep as the terminal shows it."""
    box = swept.sweep.box
    return written(
        "sweep",
        scene=box.scene,
        sides=sides(box.sides),
        points=swept.sweep.points,
        rows=rows(swept),
        reasons=swept.reasons,
        size=size,
        place=place,
    )
