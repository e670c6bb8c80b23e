"""Scenes against methods: the relative error at a step that a reader chooses, and what it means."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import DEFAULT, ConvergenceStudy
from plumbob.engines.study.measurement import (
    REFERENCE_STEP,
    Measurement,
    reference_run,
    relative_error,
    worst,
)
from plumbob.engines.study.results import Study
from plumbob.models.scene import Quantity, Scene
from plumbob.reports.advice.recommend import EXACT, UNTRUSTED
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
    best: bool = False  # of its row the smallest in its engine, or the cheapest

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
        marks = " best" * self.best + " unexpected" * (self.meaning == "unexpected")
        return f"size-{'abcdefgh'[place]}{marks}"

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
    quantities = study.quantities(series.scene)
    error, means = at_reference(series, method, quantities), meaning(judged)
    if error is None or means == "not-run" or math.isnan(error.error):
        return None
    verdicts = {m.step: j.verdict for m, j in zip(series.measurements, judged.runs, strict=True)}

    def at(run: Measurement) -> Shown:
        return judged_there(Shown(relative_error(run, quantities), run.step, method.control))

    def judged_there(of: Shown) -> Shown:
        large = means == "predicted" and verdicts[of.step] in ("pre-asymptotic", "diverged")
        return replace(of, meaning="unclaimed" if large else means)

    runs = [m for m in series.measurements if m.status in ("done", "diverged")]
    usual = LARGEST_STEP if method.control == "step" else LOOSEST
    default = min(runs, key=lambda m: abs(math.log(m.step / usual)))
    within = _largest_within(runs, quantities)
    return judged_there(error), at(default), None if within is None else at(within)


def _largest_within(
    runs: Sequence[Measurement], quantities: Sequence[Quantity]
) -> Measurement | None:
    """The run with the largest step of those that, with all smaller ones, have the error wanted."""
    largest = None
    for run in sorted(runs, key=lambda m: m.step):
        if not relative_error(run, quantities) <= WANTED:
            break
        largest = run
    return largest


def at_reference(
    series: ConvergenceStudy, method: Method, quantities: Sequence[Quantity]
) -> Shown | None:
    """The error at the reference step; where that was not run, at the step nearest to it, or at the
    tightest tolerance; and where the error crosses zero there, the larger one of those at the steps
    beside it. None where nothing was run."""
    runs = [m for m in series.measurements if m.status in ("done", "diverged")]
    if method.control == "tolerance":
        run = reference_run(runs, method)
    else:
        asked = [m for m in runs if math.isclose(m.step, REFERENCE_STEP, rel_tol=1e-9)]
        run = asked[0] if asked else reference_run(runs, method)
        run = run and _beside_zero(runs, runs.index(run), quantities)
    if run is None and not runs:
        return None
    run = run or runs[-1]
    return Shown(relative_error(run, quantities), run.step, method.control)


def _beside_zero(
    runs: Sequence[Measurement], place: int, quantities: Sequence[Quantity]
) -> Measurement:
    """The run at a place; where the error at its end changes its sign towards one of the steps
    beside it, and is smaller than at the smaller one of these, the run with the larger error."""
    run, near = runs[place], runs[max(place - 1, 0) : place + 2]
    if near[-1] is run or any(m.status != "done" for m in near):
        return run
    quantity, error = worst(run, quantities)
    ends = [m.errors[quantity.observable].end for m in near if quantity.observable in m.errors]
    if quantity.when == "run" or not min(ends, default=0.0) < 0.0 < max(ends, default=0.0):
        return run
    if error >= relative_error(near[-1], quantities):
        return run
    return max(near, key=lambda m: relative_error(m, quantities))


def every_pair(study: Study, records: Records) -> Every:
    """The errors of each method on each scene, of those that ran, with what they mean; in each row
    the best stand out."""
    methods = {m.name: m for m in study.methods}
    cells = {
        (c.scene, c.method): of
        for c in study.convergence
        if (of := shown(study, c, methods[c.method], records.verdicts[c.scene, c.method]))
    }
    for scene, record in records.scenes.items():
        errors: dict[str, dict[str, Shown]] = {}  # by engine and method
        for pair in (pair for pair in cells if pair[0] == scene):
            errors.setdefault(methods[pair[1]].engine, {})[pair[1]] = cells[pair][0]
        for of_engine in errors.values():
            pair = scene, best(of_engine, study.methods)
            at, default, within = cells[pair]
            cells[pair] = (replace(at, best=True), default, within)
        chosen = [r.choice for r in record.recommendations if r.error == WANTED and r.choice]
        if chosen and (pair := (scene, chosen[0].method)) in cells:
            at, default, within = cells[pair]
            cells[pair] = (at, default, within and replace(within, best=True))
    return cells


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


def best(errors: Mapping[str, Shown], methods: Sequence[Method]) -> str:
    """The method with the smallest error of an engine's: of those that are as predicted or
    converge, full models first, where there are any; of these those at the reference step."""
    surrogates = {m.name for m in methods if m.surrogate or m.scheme.integrator == EXACT}
    other = {n: of for n, of in errors.items() if of.meaning in ("predicted", "converges")}
    good = {name: of for name, of in other.items() if name not in surrogates}
    chosen = good or other or errors
    chosen = {name: of for name, of in chosen.items() if not of.at} or chosen
    return min(chosen, key=lambda name: chosen[name].error)
