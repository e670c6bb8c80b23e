"""A user's own settings in a study: their error at their own step, and what would be better."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from plumbob.engines.method import USER_METHOD
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Study
from plumbob.reports.judge.recommend import EXACT, Choice, cheapest, chosen
from plumbob.reports.judge.verdict import Judgement, Judgements
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
class UserResult:
    """One scene with the user's settings, and what the same study knows to be better."""

    scene: str
    observable: str
    unit: str
    step: float  # [s], the user's own
    error: float  # at that step; infinite where the run diverged
    ns_per_second: float  # [ns] of wall time per simulated second; infinite where it diverged
    judgement: Judgement  # on all steps that were run
    finest: tuple[float, float] | None  # the smallest step [s] that was run, and the error there
    as_exact: Instead  # the cheapest with an error no larger
    better: Instead  # the most accurate that costs no more


def user_results(study: Study, judged: Judgements) -> tuple[UserResult, ...]:
    """What a study, with its verdicts, says of the user's settings, a scene each; scenes that they
    did not run are left out."""
    if all(method.name != USER_METHOD for method in study.methods):
        return ()
    rest = replace(
        study,
        methods=tuple(m for m in study.methods if m.name != USER_METHOD),
        convergence=tuple(c for c in study.convergence if c.method != USER_METHOD),
    )
    return tuple(
        _of_scene(study, rest, c, judged[c.scene, USER_METHOD].whole)
        for c in study.convergence
        if c.method == USER_METHOD and c.measurements
        if c.measurements[0].status in ("done", "diverged")
    )


def _of_scene(study: Study, rest: Study, found: ConvergenceStudy, judged: Judgement) -> UserResult:
    own = found.measurements[0]
    leading = study.leading(found.scene)
    error = own.errors[leading.name].largest if own.status == "done" else math.inf
    rest = replace(
        rest, convergence=tuple(c for c in rest.convergence if not _same(c, own, leading.name))
    )
    prices = [p.ns_per_second for p in points(study, found.scene) if p.method == USER_METHOD]
    price = prices[0] if prices else math.inf
    last = next((m for m in reversed(found.measurements) if m.status == "done"), None)
    return UserResult(
        found.scene,
        leading.name,
        leading.unit,
        own.step,
        error,
        price,
        judged,
        (last.step, last.errors[leading.name].largest) if last and last is not own else None,
        _as_exact(rest, found.scene, error),
        _better(rest, found.scene, error, price),
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
    # Beside a run that diverged any error at all is as good.
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


def table(study: Study, judged: Judgements) -> Table | None:
    """Your settings, a row a scene; None in a study without any."""
    from plumbob.reports.view.overview import anchor
    from plumbob.reports.view.tables import verdict_cell

    rows, own = [], user_results(study, judged)
    for found in own:
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
                verdict_cell(found.scene, USER_METHOD, found.judgement, anchor(found.scene)),
                Cell(notation.times_real(found.ns_per_second), "number"),
                *cells,
            )
        )
    if not rows:
        return None
    step = notation.short(own[0].step)
    heads = (
        "scene", "error of", f"at your {step} s", "at a smaller step", "verdict",
        "real-time factor", "at equal accuracy, cheapest in MuJoCo", "in any engine",
        "at no greater cost, most accurate in MuJoCo", "in any engine",
    )  # fmt: skip
    note = (
        "Your options and contact defaults, with the scenes' own bodies and friction. A verdict on "
        "them is no failure of plumbob's. Costs are relative to your setting at your step."
    )
    return Table("Your settings", heads, tuple(rows), note)


def instead(own: Sequence[UserResult]) -> dict[tuple[str, str, float], dict[str, Any]]:
    """The same as plain data, by scene, method and step."""
    return {
        (found.scene, USER_METHOD, found.step): {
            "as_exact": asdict(found.as_exact),
            "no_dearer": asdict(found.better),
        }
        for found in own
    }


def lines(own: Sequence[UserResult]) -> list[str]:
    """The same for a terminal."""
    said = []
    for found in own:
        smaller = _finest(found)
        said += [
            "",
            f"{found.scene}: {found.observable} with your settings at {found.step:g} s",
            f"  {'error':<18} {_error(found)} {found.unit}"
            + (f"; {smaller}" if smaller else "")
            + f"; {found.judgement.verdict}",
        ]
        for head, kind in (
            ("at equal accuracy", found.as_exact),
            ("at no greater cost", found.better),
        ):
            choices = dict.fromkeys(c for c in (kind.here, kind.anywhere) if c is not None)
            said += [f"  {head:<18} {_said(c, found)}" for c in choices]
            if not choices:
                said.append(f"  {head:<18} nothing else that was measured")
    return said


def _instead(choice: Choice | None, found: UserResult) -> Cell:
    if choice is None:
        return Cell("–", "none")
    text = (
        f"{choice.method}\n{notation.step(choice.step, choice.control)}, {_factor(choice, found)}"
    )
    return Cell(text, "choice", f"an error of {notation.number(choice.error)} {found.unit} or less")


def _said(choice: Choice, found: UserResult) -> str:
    at = notation.step(choice.step, choice.control)
    error = f"error {notation.number(choice.error)} {found.unit}"
    return f"{choice.method} at {at}: {error}, {_factor(choice, found)}"


def _factor(choice: Choice, found: UserResult) -> str:
    """The cost of a choice in those of the user's own run."""
    if not math.isfinite(found.ns_per_second):
        return notation.times_real(choice.ns_per_second) + " real time"
    return f"{notation.number(choice.ns_per_second / found.ns_per_second, 2)} of your cost"


def _error(found: UserResult) -> str:
    return notation.number(found.error) if math.isfinite(found.error) else "diverges"


def _finest(found: UserResult) -> str:
    if found.finest is None:
        return ""
    step, error = found.finest
    return f"{notation.number(error)} at {notation.short(step)} s"
