"""Tables of hard cases: digits that a motion loses, and that methods lose beside it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from plumbob.engines.study.measurement import worst
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.advice.recommend import EXACT
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Table, row
from plumbob.reports.view.overview import anchor
from plumbob.reports.view.records import Verdicts

ROUNDING = 2.0**-53  # relative
PERCENT = 0.01


def digits_lost(relative: float) -> float:
    """Decimal digits of a double that an error of this relative size leaves without a meaning."""
    return math.log10(max(relative / ROUNDING, 1.0))


def lost_by_motion(study: Study, scene: Scene) -> float | None:
    """Digits that roundings of a scene's inputs cost its exact answer, of what the scene is about;
    None where no run of it is stored."""
    doubts = [
        run.errors[quantity.observable].uncertainty / quantity.scale
        for series in study.convergence
        if series.scene == scene.name
        for run in series.measurements
        if run.status == "done"
        for quantity in study.quantities(scene.name)
        if quantity.observable in run.errors and quantity.scale
    ]
    return digits_lost(max(doubts)) if doubts else None


def of_system(study: Study, scenes: Sequence[Scene], verdicts: Verdicts) -> Table | None:
    """The hard scenes of a system: what is hard, digits that the motion loses, and the smallest
    error of a full model there with the digits that it loses beside them."""
    rows = []
    for scene in scenes:
        if not scene.hard:
            continue
        errors = [
            (judged.smallest, method.name)
            for method in study.methods
            if not method.surrogate
            and method.scheme.integrator != EXACT
            and (judged := verdicts.get((scene.name, method.name))) is not None
            and judged.smallest is not None
        ]
        error, name = min(errors, default=(float("nan"), "none"))
        motion = lost_by_motion(study, scene)
        rows.append(
            row(
                Cell(scene.name, "scene", link=anchor(scene.name)),
                Cell(scene.hard, "text"),
                _digits(motion),
                Cell(notation.relative(error), "number"),
                Cell(name, "method"),
                _digits(_beside(error, motion)),
            )
        )
    if not rows:
        return None
    heads = (
        "scene",
        "what makes it hard",
        "digits lost by the motion",
        "smallest relative error",
        "by",
        "digits that it loses more",
    )
    return Table("Hard cases", heads, tuple(rows))


def of_scene(study: Study, scene: Scene) -> Table | None:
    """Methods on one hard scene: the smallest error of each, the digits that it loses more than the
    motion, and the largest step that was run with an error of 1 % or less."""
    motion, rows = lost_by_motion(study, scene), []
    controls = {method.name: method.control for method in study.methods}
    for series in study.convergence:
        if series.scene != scene.name:
            continue
        errors = {
            run.step: quantity_error
            for run in series.measurements
            if run.status == "done"
            for _, quantity_error in (worst(run, study.quantities(scene.name)),)
        }
        if not errors:
            continue
        least = min(errors.values())
        small = [step for step, error in errors.items() if error <= PERCENT]
        rows.append(
            row(
                Cell(series.method, "method"),
                Cell(notation.relative(least), "number"),
                _digits(_beside(least, motion)),
                Cell(_largest(small, controls[series.method]), "number"),
            )
        )
    if not rows:
        return None
    heads = ("method", "smallest error", "digits that it loses more", "largest step within 1 %")
    return Table("Digits lost", heads, tuple(rows))


def _largest(steps: Sequence[float], control: str) -> str:
    return notation.step(max(steps), control) if steps else "none run"


def _beside(error: float, motion: float | None) -> float | None:
    if motion is None or math.isnan(error):
        return None
    return max(digits_lost(error) - motion, 0.0)


def _digits(digits: float | None) -> Cell:
    return Cell("" if digits is None else f"{digits:.1f}", "number")
