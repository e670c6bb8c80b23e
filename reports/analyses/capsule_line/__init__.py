"""The page's section on the capsule on a line: the source's formulas, errors, contacts, models."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.analytic.systems.capsule import lowest_normal_forces
from plumbob.analytic.systems.manoeuvres.line_reference import condition_number
from plumbob.engines.study.extra_runs import Request, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.capsule_line import (
    contacts,
    displacement,
    drive,
    fidelity,
    source,
    source_text,
    tipping,
)
from plumbob.reports.analyses.measurements import problem
from plumbob.reports.view.content import Cell, Table, method_cell, row, value
from plumbob.reports.view.notation import short


def requests(plan: StudyPlan) -> Sequence[Request]:
    """The runs that the findings below look up."""
    return (
        *fidelity.requests(plan),
        *tipping.requests(plan),
    )


def hard(study: Study, scene: Scene) -> tuple[Table, ...]:
    """The numbers that make a case hard; each method's last error at its finest step, with its
    prediction."""
    line = problem(scene.name).motion
    lowest, _ = lowest_normal_forces(line.capsule, (line.segment,))
    about = (
        ("m/M", line.capsule.slider_mass / line.capsule.body_mass),
        ("μ w₁ / f g", line.w1 / line.capsule.holding_acceleration),
        ("μ w₂ / f g", line.w2 / line.capsule.holding_acceleration),
        ("Δx [m]", line.displacement),
        ("condition number of Δx", condition_number(line)),
        ("smallest Nᵢ over (M+m) g", float(np.min(lowest)) / line.capsule.weight),
    )
    numbers = Table(
        "What makes it hard", tuple(name for name, _ in about),
        (row(*(value(size, 7) for _, size in about)),),
        "M, m: masses of body and slider; μ = m/(M+m); w₁, w₂: accelerations of the slider in the "
        "body; f: coefficient of friction; Nᵢ: normal forces.",
    )  # fmt: skip
    rows = []
    for convergence in study.convergence:
        done = [m for m in convergence.measurements if m.status == "done"]
        if convergence.scene != scene.name or not done:
            continue
        finest = done[-1]
        error = finest.errors["displacement"]
        predicted = error.predicted.end if error.predicted else None
        rows.append(
            row(method_cell(convergence.method), Cell(short(finest.step), "number"),
                value(error.end / line.displacement), value(error.end), value(predicted))
        )  # fmt: skip
    if not rows:
        return (numbers,)
    heads = ("method", "step [s]", "relative error of Δx", "error of Δx [m]", "predicted [m]")
    note = "At the finest step of each method; predicted: the error that the step makes here."
    return numbers, Table("Final displacement", heads, tuple(rows), note)


FINDINGS = (
    source.MISPRINTS,
    source.ANY_LINE,
    source_text.SOURCE,
    displacement.ERRORS,
    displacement.SAWTOOTH,
    contacts.CHATTER,
    contacts.ISOTROPY,
    contacts.LOAD_ERRORS,
    drive.DRIVE,
    tipping.finding,
    fidelity.heights,
    fidelity.momentum,
    fidelity.saving,
)
SECTION = Section(FINDINGS, (source.FIGURE_2,), (hard,), requests)
