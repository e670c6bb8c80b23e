"""Scenes against methods: the relative error at a step that a reader chooses, and what it means."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from types import MappingProxyType
from typing import Literal

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import DEFAULT, ConvergenceStudy
from plumbob.engines.study.measurement import (
    REFERENCE_STEP,
    reference_run,
    relative_error,
)
from plumbob.engines.study.results import Study
from plumbob.models.scene import Quantity, Scene
from plumbob.reports.advice.recommend import UNTRUSTED
from plumbob.reports.view import notation
from plumbob.reports.view.records import PairVerdict, Records

Meaning = Literal["predicted", "converges", "limit", "unexpected", "unclaimed", "not-run"]
SIGNS: Mapping[Meaning, tuple[str, str, str]] = MappingProxyType(
    {
        "predicted": ("=", "as predicted", "the error is the predicted one, or within its bound"),
        "converges": ("↓", "converges", "not predicted, but smaller steps remove it"),
        "limit": ("◆", "known limit", "declared, with its reason and its size"),
        "unclaimed": ("?", "step too large", "the theory does not reach it"),
        "unexpected": ("✗", "unexpected", "not what theory or a declared limit says"),
    }
)
ORDER = (
    "cone-pendulum",
    "capsule-line",
    "capsule-turn",
    "capsule-plan",
    "capsule-hold",
    "capsule-coast",
    "capsule-train",
    "simple-pendulum",
    "linear-pendulum",
)
"""Systems in the order in which the sources treat them; others follow by name."""
ENGINES = MappingProxyType(
    {
        "mujoco": "MuJoCo",
        "pymunk": "pymunk",
        "ode": "ODE solvers",
        "heyoka": "heyoka",
        "exact": "closed form",
    }
)


LARGEST_STEP, LOOSEST = DEFAULT[1], 1e-3  # default settings: MuJoCo's step [s], scipy's tolerance
WANTED = 0.01  # relative: the error that the largest step is shown for
DECADES = 6  # below 1 that have a colour of their own: errors of 1e-6 and less have the first


@dataclass(frozen=True)
class Shown:
    """The error of a method on a scene beside the step that it was measured at."""

    error: float  # relative; infinite where the run diverged
    step: float  # [s], or the relative tolerance
    control: Literal["step", "tolerance"]
    meaning: Meaning = "predicted"

    @property
    def at(self) -> str:
        """The step, where that is not the reference step."""
        return self._beside(REFERENCE_STEP)

    @property
    def text(self) -> str:
        """The error, with its step where that is not the reference step."""
        return f"{self._size} at {self.at}" if self.at else self._size

    def cell(self, column: float | None) -> str:
        """The sign and the error, with the step where that is not the column's [s]."""
        at = self._beside(column)
        return f"{SIGNS[self.meaning][0]} {self._size}" + (f"\n{at}" if at else "")

    @property
    def word(self) -> str:
        """The sign in words."""
        return SIGNS[self.meaning][1]

    @property
    def look(self) -> str:
        """The classes of its cell: the decade of its error, from 0 to 7, and what stands out."""
        decade = math.ceil(math.log10(max(self.error, 1e-99)) - 1e-9) if self.error < 1.0 else 0
        place = DECADES + 1 if self.error > 1.0 else max(DECADES + decade, 0)
        return f"size-{'abcdefgh'[place]}{' unexpected' * (self.meaning == 'unexpected')}"

    @property
    def _size(self) -> str:
        return "diverged" if math.isinf(self.error) else notation.relative(self.error)

    def _beside(self, column: float | None) -> str:
        """The step, where that is not the column's [s]."""
        if self.control == "step" and column and math.isclose(self.step, column, rel_tol=1e-9):
            return ""
        return notation.step(self.step, self.control)


Steps = tuple[Shown, Shown, Shown | None]
"""At the reference step, at default settings, and at the largest step for the error wanted."""
Every = Mapping[tuple[str, str], Steps]  # by scene and method


@dataclass(frozen=True)
class Matrix:
    """Scenes of one kind against the methods that ran any of them."""

    kind: str
    methods: tuple[str, ...]
    rows: tuple[tuple[str, tuple[Steps | None, ...]], ...]  # scenes, with a cell a method


def in_order(names: Sequence[str]) -> list[str]:
    """Systems in the order of the sources, those that no source has after them."""
    return sorted(names, key=lambda n: (ORDER.index(n) if n in ORDER else len(ORDER), n))


def ordered(scenes: Sequence[Scene]) -> tuple[Scene, ...]:
    """Scenes in the order of their systems."""
    places = in_order(sorted({scene.system for scene in scenes}))
    return tuple(sorted(scenes, key=lambda scene: places.index(scene.system)))


def meaning(judged: PairVerdict) -> Meaning:
    """A verdict's meaning to a reader."""
    if judged.mark == "unexpected":
        return "unexpected"
    if judged.verdict in ("unsupported", "missing"):
        return "not-run"
    if judged.mark == "known" or judged.verdict in UNTRUSTED:
        return "limit"
    if judged.verdict == "pre-asymptotic":
        return "unclaimed"
    return "converges" if judged.verdict == "converges" else "predicted"


def shown(
    study: Study, series: ConvergenceStudy, method: Method, judged: PairVerdict
) -> Steps | None:
    """The error of a method on a scene at three steps, and what it means; None where it did not
    run."""
    quantities, means = study.quantities(series.scene), meaning(judged)
    error = at_reference(series, method, quantities)
    if error is None or means == "not-run" or math.isnan(error.error):
        return None
    verdicts = {m.step: j.verdict for m, j in zip(series.measurements, judged.runs, strict=True)}
    errors = _errors(series, quantities)
    usual = LARGEST_STEP if method.control == "step" else LOOSEST

    def at(step: float) -> Shown:
        large = means == "predicted" and verdicts[step] in ("pre-asymptotic", "diverged")
        return Shown(errors[step], step, method.control, "unclaimed" if large else means)

    # The largest step that, with all smaller ones, has the error wanted.
    steps = sorted(errors)
    within = [*takewhile(lambda step: errors[step] <= WANTED, steps)]
    default = min(errors, key=lambda step: abs(math.log(step / usual)))
    return at(error.step), at(default), at(within[-1]) if within else None


def _errors(series: ConvergenceStudy, quantities: Sequence[Quantity]) -> dict[float, float]:
    """The relative errors of the runs by step, infinite where one diverged."""
    runs = [m for m in series.measurements if m.status in ("done", "diverged")]
    return {run.step: relative_error(run, quantities) for run in runs}


def at_reference(
    series: ConvergenceStudy, method: Method, quantities: Sequence[Quantity]
) -> Shown | None:
    """The error at the reference step; where that was not run, at the step nearest to it, or at the
    tightest tolerance. None where nothing was run."""
    errors = _errors(series, quantities)
    run = reference_run(series.measurements, method)
    step = REFERENCE_STEP if method.control == "step" and REFERENCE_STEP in errors else None
    step = step or (run.step if run else next(reversed(errors), None))
    return None if step is None else Shown(errors[step], step, method.control)


def every_pair(study: Study, records: Records) -> Every:
    """The errors of each method on each scene, of those that ran, with what they mean."""
    methods = {m.name: m for m in study.methods}
    return {
        (c.scene, c.method): of
        for c in study.convergence
        if (of := shown(study, c, methods[c.method], records.verdicts[c.scene, c.method]))
    }


def matrices(study: Study, every: Every, scenes: Sequence[Scene]) -> tuple[Matrix, ...]:
    """A matrix for each kind of system."""
    names = [m.name for engine in engines(study) for m in study.methods if m.engine == engine]
    tables = []
    for kind in dict.fromkeys(scene.kind for scene in scenes):
        own = [scene.name for scene in scenes if scene.kind == kind]
        ran = tuple(name for name in names if any((scene, name) in every for scene in own))
        rows = tuple((scene, tuple(every.get((scene, name)) for name in ran)) for scene in own)
        tables.append(Matrix(kind, ran, rows))
    return tuple(tables)


def engines(study: Study) -> tuple[str, ...]:
    """The engines of a study in the order of ENGINES, others after them by name."""
    first = list(ENGINES)
    every = {m.engine for m in study.methods}
    return tuple(sorted(every, key=lambda e: (first.index(e) if e in first else len(first), e)))
