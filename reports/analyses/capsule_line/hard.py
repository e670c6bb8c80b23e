"""Numbers that make a line manoeuvre hard for engines, and how near they come to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.analytic.systems.capsule import lowest_normal_forces
from plumbob.analytic.systems.manoeuvres.line_reference import condition_number
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.measurements import problem


@dataclass(frozen=True)
class End:
    """The error of a method's displacement at its finest step [m], and its prediction."""

    method: str
    step: float  # [s]
    relative: float
    error: float
    predicted: float | None


@dataclass(frozen=True)
class HardLine:
    """A manoeuvre's masses and accelerations as ratios, its displacement, and methods' errors."""

    masses: float  # slider over body
    pushing: float  # accelerations of the slider, over what friction holds
    braking: float
    displacement: float  # [m]
    condition: float
    lightest: float  # the smallest normal force over the weight
    ends: tuple[End, ...]


def numbers(study: Study, scene: Scene) -> HardLine:
    """The ratios of a hard case; each method's last error at its finest step."""
    line = problem(scene.name).motion
    body = line.capsule
    lowest, _ = lowest_normal_forces(body, (line.segment,))
    ends = list[End]()
    for series in study.convergence:
        done = [run for run in series.measurements if run.status == "done"]
        if series.scene == scene.name and done:
            error = done[-1].errors["displacement"]
            predicted = error.predicted.end if error.predicted else None
            relative = error.end / line.displacement
            ends.append(End(series.method, done[-1].step, relative, error.end, predicted))
    return HardLine(
        body.slider_mass / body.body_mass,
        line.w1 / body.holding_acceleration,
        line.w2 / body.holding_acceleration,
        line.displacement,
        condition_number(line),
        float(np.min(lowest)) / body.weight,
        tuple(ends),
    )


HARD = Analysis("capsule_line/hard", numbers)
