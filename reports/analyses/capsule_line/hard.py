"""Numbers that make a line manoeuvre hard for engines, and how near they come to it."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.systems.capsule import lowest_normal_forces
from plumbob.analytic.systems.manoeuvres.line_reference import condition_number
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.measurements import problem


def numbers(study: Study, scene: Scene) -> Record:
    """The ratios of a hard case; each method's last error at its finest step."""
    line = problem(scene.name).motion
    body = line.capsule
    lowest, _ = lowest_normal_forces(body, (line.segment,))
    ends = list[Record]()
    for series in study.convergence:
        done = [run for run in series.measurements if run.status == "done"]
        if series.scene == scene.name and done:
            error = done[-1].errors["displacement"]
            predicted = error.predicted.end if error.predicted else None
            relative = error.end / line.displacement
            ends.append(
                Record(
                    method=series.method,
                    step=done[-1].step,  # [s]
                    relative=relative,
                    error=error.end,
                    predicted=predicted,
                )
            )
    return Record(
        masses=body.slider_mass / body.body_mass,  # slider over body
        # accelerations of the slider, over what friction holds
        pushing=line.w1 / body.holding_acceleration,
        braking=line.w2 / body.holding_acceleration,
        displacement=line.displacement,  # [m]
        condition=condition_number(line),
        lightest=float(np.min(lowest)) / body.weight,  # the smallest normal force over the weight
        ends=ends,
    )


HARD = Analysis("capsule_line/hard", numbers)
