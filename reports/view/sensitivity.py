"""The table of a scene that says which change of each parameter every verdict would notice."""

from __future__ import annotations

from collections.abc import Mapping

from plumbob.engines.method import Method
from plumbob.reports.judge.tightness import Noticed
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Table, row
from plumbob.reports.view.records import PairVerdict, Sensitivity

CAPTION = "The smallest change of each parameter that the verdict would notice"
NOTE = (
    "With this parameter changed by this much in the engine alone the method would fail: the "
    "change moves an observable, at some moment, by more than is allowed there, beside the present "
    "difference. Relative changes, or in SI units where the parameter is zero. Hover for the "
    "observable and the step that notice it. A dash: no change up to the parameter's own size is "
    "noticed, as a rule because the motion does not depend on it. Where the verdict is not "
    "`predicted`, hover for the reason."
)


def table(
    sensitivity: Sensitivity, verdicts: Mapping[str, PairVerdict], methods: Mapping[str, Method]
) -> Table:
    """Methods against parameters, of a scene."""
    rows = []
    for method, verdict in verdicts.items():
        if verdict.verdict in ("unsupported", "missing"):
            continue
        name = Cell(method, "method")
        if verdict.verdict != "predicted":
            text, why = _why(verdict)
            rows.append(row(name, Cell(text, "none", why, span=len(sensitivity.parameters))))
            continue
        least = sensitivity.noticed[method]
        cells = (_cell(p, least.get(p), methods[method]) for p in sensitivity.parameters)
        rows.append(row(name, *cells))
    heads = [p if value else f"{p} (from 0)" for p, value in sensitivity.parameters.items()]
    return Table(CAPTION, ("method", *heads), tuple(rows), NOTE, folded=True)


def _cell(parameter: str, least: Noticed | None, method: Method) -> Cell:
    if least is None or least.change > 1.0:
        return Cell("–", "number", f"no change of {parameter} up to its own size is noticed")
    at = notation.step(least.step, method.control)
    return Cell(notation.number(least.change, 2), "number", f"by {least.observable} at {at}")


def _why(verdict: PairVerdict) -> tuple[str, str]:
    """A verdict in short, and its reason."""
    text = f"not judged by a prediction: {verdict.verdict.replace('-', ' ')}"
    return (f"{text} (known)", verdict.declared) if verdict.as_declared else (text, verdict.reason)
