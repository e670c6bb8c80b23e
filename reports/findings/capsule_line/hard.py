"""What a hard case of the line shows beside the rest: its numbers, each method's final error."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.systems.capsule import lowest_normal_forces
from plumbob.analytic.systems.manoeuvres.line_reference import condition_number
from plumbob.engines.study.study import Study
from plumbob.models.scene import Scene
from plumbob.reports.findings.capsule.cells import method as method_cell
from plumbob.reports.findings.capsule.cells import value
from plumbob.reports.findings.capsule.runs import problem
from plumbob.reports.view.content import Cell, Figure, Table, row
from plumbob.reports.view.notation import short


def hard(study: Study, scene: Scene) -> tuple[Figure | Table, ...]:
    """What makes the case hard, in numbers; and what theory predicted of each method's last error,
    at its finest step."""
    line = problem(scene.name).motion
    least, _ = lowest_normal_forces(line.capsule, (line.segment,))
    about = (
        ("m/M", line.capsule.slider_mass / line.capsule.body_mass),
        ("μ w₁ / f g", line.w1 / line.capsule.holding_acceleration),
        ("μ w₂ / f g", line.w2 / line.capsule.holding_acceleration),
        ("Δx [m]", line.displacement),
        ("condition number of Δx", condition_number(line)),
        ("least Nᵢ over (M+m) g", float(np.min(least)) / line.capsule.weight),
    )
    numbers = Table(
        "What makes it hard", tuple(name for name, _ in about),
        (row(*(value(number, 7) for _, number in about)),),
    )  # fmt: skip
    rows = []
    for convergence_study in study.convergence:
        done = [m for m in convergence_study.measurements if m.status == "done"]
        if convergence_study.scene != scene.name or not done:
            continue
        finest = done[-1]
        error = finest.errors["displacement"]
        told = error.predicted.end if error.predicted else None
        rows.append(
            row(method_cell(convergence_study.method), Cell(short(finest.step), "number"),
                value(error.end / line.displacement), value(error.end), value(told))
        )  # fmt: skip
    if not rows:
        return (numbers,)
    heads = ("method", "step [s]", "relative error of Δx", "error of Δx [m]", "predicted [m]")
    note = "At the finest step of each method; predicted: what the step does to this motion."
    return numbers, Table("Final displacement", heads, tuple(rows), note)
