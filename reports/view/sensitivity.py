"""The table of a scene that says which change of each parameter every verdict would notice."""

from __future__ import annotations

from plumbob.engines.method import Method
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.judge.expectations import expected
from plumbob.reports.judge.sensitivity import Noticed, Parameter, Sensitivities
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.judge.verdict import Judgement
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Table, row

CAPTION = "The smallest change of each parameter that the verdict would notice"
NOTE = (
    "With this parameter changed by this much in the engine alone the method would fail: the "
    "change moves an observable, at some moment, by more than is allowed there, beside the present "
    "difference. Relative changes, or in SI units where the parameter is zero. Hover for the "
    "observable and the step that notice it. A dash: no change up to the parameter's own size is "
    "noticed, as a rule because the motion does not depend on it. Where the verdict is not `pass`, "
    "hover for the reason."
)


def table(study: Study, scene: Scene, judged: Judgements) -> Table | None:
    """Methods against parameters; None where no verdict is `pass`, or nothing can be changed."""
    ran = [c for c in study.convergence if c.scene == scene.name]
    pairs = {c.method: judged[c.scene, c.method] for c in ran}
    if not any(pair.whole.verdict == "pass" for pair in pairs.values()):
        return None
    sensitivities = Sensitivities(scene)
    parameters = tuple(sensitivities.slopes)
    if not parameters:
        return None
    methods = {method.name: method for method in study.methods}
    rows = []
    for c in ran:
        pair, method = pairs[c.method], methods[c.method]
        if pair.whole.verdict in ("unsupported", "missing"):
            continue
        name = Cell(c.method, "method")
        if pair.whole.verdict != "pass":
            text, why = _why(scene.name, c.method, pair.whole)
            rows.append(row(name, Cell(text, "none", why, span=len(parameters))))
            continue
        least = sensitivities.noticed(c, pair)
        rows.append(row(name, *(_cell(p, least.get(p), method) for p in parameters)))
    heads = ("method", *(_head(parameter) for parameter in parameters))
    return Table(CAPTION, heads, tuple(rows), NOTE, folded=True)


def _head(parameter: Parameter) -> str:
    return parameter.label if parameter.value else f"{parameter.label} (from 0)"


def _cell(parameter: Parameter, least: Noticed | None, method: Method) -> Cell:
    if least is None or least.change > 1.0:
        hint = f"no change of {parameter.label} up to its own size is noticed"
        return Cell("–", "number", hint)
    at = notation.step(least.step, method.control)
    return Cell(notation.number(least.change, 2), "number", f"by {least.observable} at {at}")


def _why(scene: str, method: str, judgement: Judgement) -> tuple[str, str]:
    """A verdict in short, and its reason."""
    limit = expected(scene, method)
    known = limit.verdict != "pass" and limit.allows(judgement)
    text = f"not judged by a prediction: {judgement.verdict.replace('-', ' ')}"
    return (f"{text} (known)", limit.reason) if known else (text, judgement.reason)
