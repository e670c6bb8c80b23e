"""A user's own settings in a study: how wrong at their own step, and what would be better."""

from __future__ import annotations

import math
import sys
from dataclasses import asdict, dataclass, replace
from typing import Any

from plumbob.engines.adapters.mujoco.like import NAME
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.study import Study
from plumbob.models.registry import system_of
from plumbob.reports.judge.recommend import EXACT, Choice, cheapest, chosen
from plumbob.reports.judge.verdict import Judgement, judge_convergence
from plumbob.reports.judge.work_precision import Point, points
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Table, row

HERE = "mujoco/"  # methods that are other settings of the user's own engine


@dataclass(frozen=True)
class Instead:
    """What to use in place of a setting: in the user's engine, and in any."""

    here: Choice | None
    anywhere: Choice | None


@dataclass(frozen=True)
class Yours:
    """One scene with the user's settings, and what the same study knows to be better."""

    scene: str
    observable: str
    unit: str
    step: float  # [s], the user's own
    error: float  # at that step; infinite where the run diverged
    ns_per_second: float  # [ns] of wall time per simulated second; infinite where it diverged
    judgement: Judgement  # on all steps that were run
    finest: tuple[float, float] | None  # the smallest step [s] that was run, and the error there
    as_exact: Instead  # the cheapest that errs no more
    better: Instead  # the most exact that costs no more


def yours(study: Study) -> tuple[Yours, ...]:
    """What a study says of the user's settings, a scene each, those that did not run left out."""
    if all(method.name != NAME for method in study.methods):
        return ()
    rest = replace(
        study,
        methods=tuple(m for m in study.methods if m.name != NAME),
        convergence=tuple(c for c in study.convergence if c.method != NAME),
    )
    return tuple(
        _of_scene(study, rest, c, c.measurements[0])
        for c in study.convergence
        if c.method == NAME and c.measurements
        if c.measurements[0].status in ("done", "diverged")
    )


def _of_scene(study: Study, rest: Study, found: ConvergenceStudy, own: Measurement) -> Yours:
    scene = next(s for s in study.scenes if s.name == found.scene)
    method = next(m for m in study.methods if m.name == NAME)
    system = system_of(scene)
    leading = system.observables[0]
    error = own.errors[leading.name].largest if own.status == "done" else math.inf
    rest = replace(
        rest, convergence=tuple(c for c in rest.convergence if not _same(c, own, leading.name))
    )
    prices = [p.ns_per_second for p in points(study, scene.name) if p.method == NAME]
    price = prices[0] if prices else math.inf
    last = next((m for m in reversed(found.measurements) if m.status == "done"), None)
    return Yours(
        scene.name,
        leading.name,
        leading.unit,
        own.step,
        error,
        price,
        judge_convergence(found, system, method),
        (last.step, last.errors[leading.name].largest) if last and last is not own else None,
        _as_exact(rest, scene.name, error),
        _better(rest, scene.name, error, price),
    )


def _same(other: ConvergenceStudy, own: Measurement, leading: str) -> bool:
    """Whether another method of the user's engine does to the last bits what the user's setting
    does: it is that very setting, by another name."""
    if own.status != "done" or other.scene != own.scene or not other.method.startswith(HERE):
        return False
    error = own.errors[leading].end
    return any(
        m.step == own.step and m.status == "done"
        and math.isclose(m.errors[leading].end, error, rel_tol=1e-12)
        for m in other.measurements
    )  # fmt: skip


def _as_exact(rest: Study, scene: str, error: float) -> Instead:
    # Of a run that diverged any error at all is as good.
    within = min(max(error, sys.float_info.min), sys.float_info.max)
    found = cheapest(rest, scene, within)
    return Instead(
        next((c for c in found.by_engine if c.method.startswith(HERE)), None), found.choice
    )


def _better(rest: Study, scene: str, error: float, price: float) -> Instead:
    exact = {m.name for m in rest.methods if m.scheme.integrator == EXACT}
    methods = {m.name: m for m in rest.methods}
    found = [
        p
        for p in points(rest, scene)
        if p.method not in exact and p.ns_per_second <= price and p.error < error
    ]

    def most_exact(start: str) -> Choice | None:
        best: Point | None = min(
            (p for p in found if p.method.startswith(start)),
            key=lambda p: (p.error, p.ns_per_second),
            default=None,
        )
        return chosen(methods[best.method], best) if best else None

    return Instead(most_exact(HERE), most_exact(""))


def table(study: Study) -> Table | None:
    """Your settings, a row a scene; None in a study without any."""
    from plumbob.reports.view.overview import anchor
    from plumbob.reports.view.tables import verdict_cell

    rows = []
    for found in yours(study):
        cells = [
            _instead(getattr(kind, place), found)
            for kind in (found.as_exact, found.better)
            for place in ("here", "anywhere")
        ]
        rows.append(
            row(
                Cell(found.scene, "scene", "", anchor(found.scene)),
                f"{found.observable} [{found.unit}]",
                Cell(_error(found), "number"),
                Cell(_finest(found), "number"),
                verdict_cell(found.scene, NAME, found.judgement, anchor(found.scene)),
                Cell(notation.times_real(found.ns_per_second), "number"),
                *cells,
            )
        )
    if not rows:
        return None
    step = notation.short(next(iter(yours(study))).step)
    heads = (
        "scene", "error of", f"at your {step} s", "at a smaller step", "verdict",
        "times real time", "as exact, cheapest in MuJoCo", "in any engine",
        "no dearer, most exact in MuJoCo", "in any engine",
    )  # fmt: skip
    note = (
        "Your options and contact defaults, with the scenes' own bodies and friction. A verdict on "
        "them breaks no promise. Costs are those of your setting at your step, times the factor."
    )
    return Table("Your settings", heads, tuple(rows), note)


def instead(study: Study) -> dict[tuple[str, str, float], dict[str, Any]]:
    """The same as plain data, by scene, method and step."""
    return {
        (found.scene, NAME, found.step): {
            "as_exact": asdict(found.as_exact),
            "no_dearer": asdict(found.better),
        }
        for found in yours(study)
    }


def lines(study: Study) -> list[str]:
    """The same for a terminal."""
    said = []
    for found in yours(study):
        smaller = _finest(found)
        said += [
            "",
            f"{found.scene}: {found.observable} with your settings at {found.step:g} s",
            f"  error        {_error(found)} {found.unit}"
            + (f"; {smaller}" if smaller else "")
            + f"; {found.judgement.verdict}",
        ]
        for head, kind in (("as exact", found.as_exact), ("no dearer", found.better)):
            told = dict.fromkeys(c for c in (kind.here, kind.anywhere) if c is not None)
            said += [f"  {head:<12} {_said(c, found)}" for c in told]
            if not told:
                said.append(f"  {head:<12} nothing else that was measured")
    return said


def _instead(choice: Choice | None, found: Yours) -> Cell:
    if choice is None:
        return Cell("–", "none")
    text = (
        f"{choice.method}\n{notation.step(choice.step, choice.control)}, {_factor(choice, found)}"
    )
    return Cell(text, "choice", f"errs by {notation.number(choice.error)} {found.unit} or less")


def _said(choice: Choice, found: Yours) -> str:
    at = notation.step(choice.step, choice.control)
    error = f"errs by {notation.number(choice.error)} {found.unit}"
    return f"{choice.method} at {at}: {error}, {_factor(choice, found)}"


def _factor(choice: Choice, found: Yours) -> str:
    """The cost of a choice in those of the user's own run."""
    if not math.isfinite(found.ns_per_second):
        return notation.times_real(choice.ns_per_second) + " real time"
    return f"{notation.number(choice.ns_per_second / found.ns_per_second, 2)} of your cost"


def _error(found: Yours) -> str:
    return notation.number(found.error) if math.isfinite(found.error) else "diverges"


def _finest(found: Yours) -> str:
    if found.finest is None:
        return ""
    step, error = found.finest
    return f"{notation.number(error)} at {notation.short(step)} s"
