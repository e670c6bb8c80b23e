"""A user's own settings as a page and a terminal show them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from plumbob.engines.method import USER_METHOD
from plumbob.reports.advice.recommend import Choice
from plumbob.reports.advice.user_settings import UserResult
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Table, row
from plumbob.reports.view.overview import anchor
from plumbob.reports.view.tables import verdict_cell


def table(own: Sequence[UserResult]) -> Table | None:
    """Your settings, a row a scene; None in a study without any."""
    rows = []
    for found in own:
        cells = [
            _instead(getattr(kind, place), found)
            for kind in (found.at_equal_accuracy, found.better)
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


def lines(own: Sequence[UserResult]) -> list[str]:
    """The same as lines for a terminal."""
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
            ("at equal accuracy", found.at_equal_accuracy),
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
    return Cell(
        text, "choice", f"an error of {notation.number(choice.absolute)} {found.unit} or less"
    )


def _said(choice: Choice, found: UserResult) -> str:
    at = notation.step(choice.step, choice.control)
    error = f"error {notation.number(choice.absolute)} {found.unit}"
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
