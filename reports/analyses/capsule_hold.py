"""The page's section on the capsule held by friction on a tilted plane: how far it drifts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from plumbob.engines.study.results import Study
from plumbob.models.registry import scenes as find_scenes
from plumbob.reports.analyses.analysis import Analysis, Section
from plumbob.reports.analyses.claims import clear
from plumbob.reports.analyses.measurements import covers, measured, names
from plumbob.reports.view.content import Claim

STEPS = (1e-3, 2e-3)  # [s]: the first that a study has is shown; the quick profile has the second
SLIDES = 0.1  # [m]: more than any drift of stiction, in ten seconds


@dataclass(frozen=True)
class Drift:
    """How far a body moves that should rest."""

    distance: float | None  # [m]; None: not measured
    duration: float  # [s]

    @property
    def speed(self) -> float | None:
        """Its mean [m/s]."""
        return None if self.distance is None else self.distance / self.duration

    @property
    def slides(self) -> bool:
        """Whether friction has given way."""
        return self.distance is not None and self.distance > SLIDES


@dataclass(frozen=True)
class Drifts:
    """A method's drifts, on each scene."""

    method: str
    drifts: tuple[Drift, ...]


@dataclass(frozen=True)
class Stiction:
    """Drifts of all methods on scenes of growing tilt."""

    scenes: tuple[str, ...]
    step: float  # [s]
    rows: tuple[Drifts, ...]

    def steepest(self, *ends: str) -> list[float]:
        """The distances [m] on the last scene, of methods whose names end so."""
        last = {row.method: row.drifts[-1].distance for row in self.rows}
        return [d for name, d in last.items() if d is not None and name.endswith(ends)]

    @property
    def ran(self) -> bool:
        """Whether a method ran on the last scene."""
        return bool(self.steepest(""))

    @property
    def convergent(self) -> float | None:
        """The largest distance [m] there on convergent contacts."""
        return max(self.steepest("coulomb", "feet", "side"), default=None)

    @property
    def noslip(self) -> float | None:
        """The same with noslip."""
        return max(self.steepest("coulomb+noslip"), default=None)


def numbers(study: Study) -> Stiction | None:
    """Drift of each method at each fraction of the threshold that was run; None where none was."""
    tilted = [s for s in find_scenes("capsule-hold") if covers(study, s.name)]
    tilted = [scene for scene in tilted if "length" not in scene.parameters]
    if not tilted:
        return None
    scenes, step = tuple(scene.name for scene in tilted), _step(study, tilted[-1].name)
    rows = []
    for name in names(study):
        distances = [_distance(study, scene, name, step) for scene in scenes]
        pairs = zip(distances, tilted, strict=True)
        drifts = tuple(Drift(distance, scene.duration) for distance, scene in pairs)
        if any(distance is not None for distance in distances):
            rows.append(Drifts(name, drifts))
    return Stiction(scenes, step, tuple(rows))


def _step(study: Study, scene: str) -> float:
    """The first of STEPS at which any method was measured on a scene."""
    ran = (s for s in STEPS if any(measured(study, scene, name, s) for name in names(study)))
    return next(ran, STEPS[0])


def _distance(study: Study, scene: str, method: str, step: float) -> float | None:
    run = measured(study, scene, method, step)
    return None if run is None else abs(run.errors["displacement"].end)


def claims(numbers: Stiction) -> Sequence[Claim]:
    """Contact models differ by much."""
    known = numbers.steepest("")
    text = "the fastest drift and the slowest"
    return [clear(text, max(known), min(known), "m")] if len(known) > 1 else ()


SECTION = Section((Analysis("capsule_hold/stiction_drift", numbers, claims=claims),))
