"""The page's section on the capsule held by friction on a tilted plane: how far it drifts."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.results import Study
from plumbob.models.registry import scenes as find_scenes
from plumbob.models.scene import Scene
from plumbob.reports.analyses.analysis import Analysis, Record, Section
from plumbob.reports.analyses.claims import Claims, clear
from plumbob.reports.analyses.measurements import covers, measured, names

STEPS = (1e-3, 2e-3)  # [s]: the first that a study has is shown; the quick profile has the second
SLIDES = 0.1  # [m]: more than any drift of stiction, in ten seconds


def numbers(study: Study) -> Record | None:
    """Drift of each method at each fraction of the threshold that was run; None where none was."""
    tilted = [s for s in find_scenes("capsule-hold") if covers(study, s.name)]
    tilted = [scene for scene in tilted if "length" not in scene.parameters]
    if not tilted:
        return None
    step = _step(study, tilted[-1].name)
    rows = tuple(row for name in names(study) if (row := _drifts(study, tilted, name, step)))
    groups = {
        "all": _steepest(rows, ""),
        "convergent": _steepest(rows, "coulomb", "feet", "side"),
        "noslip": _steepest(rows, "coulomb+noslip"),
    }
    return Record(
        scenes=[scene.name for scene in tilted],
        step=step,  # [s]
        rows=rows,
        slides=SLIDES,
        # the largest [m] of all, on convergent contacts, and with noslip
        largest={name: max(sizes, default=None) for name, sizes in groups.items()},
    )


def _steepest(rows: Sequence[Record], *ends: str) -> list[float]:
    """The distances [m] on the last scene, of methods whose names end so."""
    last = [row.distances[-1] for row in rows if row.method.endswith(ends)]
    return [distance for distance in last if distance is not None]


def _step(study: Study, scene: str) -> float:
    """The first of STEPS at which any method was measured on a scene."""
    ran = (s for s in STEPS if any(measured(study, scene, name, s) for name in names(study)))
    return next(ran, STEPS[0])


def _drifts(study: Study, tilted: Sequence[Scene], method: str, step: float) -> Record | None:
    """How far a body moves with a method that should rest, on each scene."""
    distances, speeds = [], []
    for scene in tilted:
        run = measured(study, scene.name, method, step)
        distance = None if run is None else abs(run.errors["displacement"].end)
        distances.append(distance)
        speeds.append(None if distance is None else distance / scene.duration)
    if all(distance is None for distance in distances):
        return None
    return Record(
        method=method,
        distances=distances,  # [m]; None: not measured
        speeds=speeds,  # [m/s], their means
    )


def claims(numbers: Record) -> Claims:
    """Contact models differ by much."""
    known = _steepest(numbers.rows, "")
    text = "the fastest drift and the slowest"
    return [clear(text, max(known), min(known), "m")] if len(known) > 1 else ()


SECTION = Section((Analysis("capsule_hold/stiction_drift", numbers, claims=claims),))
