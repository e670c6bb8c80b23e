"""Scenes against methods: the relative error at the reference step, and what it means."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import (
    REFERENCE_STEP,
    Measurement,
    reference_run,
    relative_error,
    worst,
)
from plumbob.engines.study.results import Study
from plumbob.models.scene import Quantity, Scene
from plumbob.reports.advice.recommend import DEFAULT_METHOD, EXACT, UNTRUSTED
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Table
from plumbob.reports.view.records import PairVerdict, Verdicts
from plumbob.reports.view.tables import table

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


@dataclass(frozen=True)
class Shown:
    """The error of a method on a scene beside the step that it was measured at."""

    error: float  # relative; infinite where the run diverged
    step: float  # [s], or the relative tolerance
    control: Literal["step", "tolerance"]
    meaning: Meaning = "predicted"
    reason: str = ""

    @property
    def at(self) -> str:
        """The step, where that is not the reference step."""
        if self.control == "step" and math.isclose(self.step, REFERENCE_STEP, rel_tol=1e-9):
            return ""
        return notation.step(self.step, self.control)

    @property
    def text(self) -> str:
        """The error, with its step where that is not the reference step."""
        error = "diverged" if math.isinf(self.error) else notation.relative(self.error)
        return f"{error} at {self.at}" if self.at else error

    def cell(self, method: str = "") -> Cell:
        """The error with its sign, and below it the method where the column does not say it."""
        if self.meaning == "not-run":
            return Cell("–", "none", self.reason)
        below = "".join(f"\n{part}" for part in (method,) if part)
        return Cell(f"{SIGNS[self.meaning][0]} {self.text}{below}", f"sign {self.meaning}")


Every = Mapping[tuple[str, str], Shown]  # by scene and method


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


def shown(study: Study, series: ConvergenceStudy, method: Method, judged: PairVerdict) -> Shown:
    """The error of a method on a scene at the reference step, and what it means."""
    means = meaning(judged)
    error = at_reference(series, method, study.quantities(series.scene))
    if error is None:
        means = means if judged.verdict == "cut-short" else "not-run"
        return Shown(math.nan, REFERENCE_STEP, "step", means, judged.reason)
    verdicts = {m.step: j.verdict for m, j in zip(series.measurements, judged.runs, strict=True)}
    if means == "predicted" and verdicts[error.step] in ("pre-asymptotic", "diverged"):
        means = "unclaimed"
    return replace(error, meaning=means, reason=judged.reason)


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


def every_pair(study: Study, verdicts: Verdicts) -> Every:
    """The error of each method on each scene at the reference step, and what it means."""
    methods = {m.name: m for m in study.methods}
    return {
        (c.scene, c.method): shown(study, c, methods[c.method], verdicts[c.scene, c.method])
        for c in study.convergence
    }


def by_engine(study: Study, every: Every, scenes: Sequence[Scene]) -> Table:
    """Scenes against engines: MuJoCo's default settings, and of each engine the method with the
    smallest error at the reference step among those that nothing is known against."""
    named = {scene.name for scene in scenes}
    ran = {
        name for (scene, name), of in every.items() if scene in named and of.meaning != "not-run"
    }
    engines = _in_order({m.engine for m in study.methods if m.name in ran} - {"exact"})
    default = any((scene.name, DEFAULT_METHOD) in every for scene in scenes)
    rows = []
    for scene in scenes:
        usual = every.get((scene.name, DEFAULT_METHOD))
        cells = [usual.cell() if usual else Cell("–", "none")] if default else []
        for engine in engines:
            of_engine = {
                m.name: of
                for m in study.methods
                if m.engine == engine and (of := every.get((scene.name, m.name))) is not None
            }
            cells.append(_best(of_engine, study.methods))
        rows.append((scene.name, cells))
    return table(
        "matrix",
        default=default,
        engines=[ENGINES.get(engine, engine) for engine in engines],
        rows=rows,
        times=any("×" in cell.text for _, cells in rows for cell in cells),
    )


def of_engines(study: Study, every: Every, scenes: Sequence[Scene]) -> tuple[Table, ...]:
    """A folded table for each engine: scenes against all of its methods that run any of them."""
    tables = []
    for engine in _in_order({m.engine for m in study.methods}):
        methods = [
            m.name
            for m in study.methods
            if m.engine == engine
            and any(
                every[key].meaning != "not-run"
                for scene in scenes
                if (key := (scene.name, m.name)) in every
            )
        ]
        rows = [
            (scene.name, [every.get((scene.name, name)) for name in methods])
            for scene in scenes
            if any((scene.name, name) in every for name in methods)
        ]
        if methods and rows:
            shown = ENGINES.get(engine, engine)
            tables.append(table("matrix_of_engine", engine=shown, methods=methods, rows=rows))
    return tuple(tables)


def _best(of_engine: Mapping[str, Shown], methods: Sequence[Method]) -> Cell:
    """The smallest error of an engine's methods: of those that are as predicted or converge, full
    models first, where there are any; of these those at the reference step."""
    surrogates = {m.name for m in methods if m.surrogate or m.scheme.integrator == EXACT}
    ran = {name: of for name, of in of_engine.items() if of.meaning != "not-run"}
    good = {
        name: of
        for name, of in ran.items()
        if of.meaning in ("predicted", "converges") and name not in surrogates
    }
    other = {name: of for name, of in ran.items() if of.meaning in ("predicted", "converges")}
    if not (chosen := good or other or ran):
        return Cell("–", "none")
    chosen = {name: of for name, of in chosen.items() if not of.at} or chosen
    name = min(chosen, key=lambda name: chosen[name].error)
    return chosen[name].cell(name.partition("/")[2])


def _in_order(engines: set[str]) -> list[str]:
    """Engines in the order of ENGINES, others after them by name."""
    first = list(ENGINES)
    return sorted(engines, key=lambda e: (first.index(e) if e in first else len(first), e))
