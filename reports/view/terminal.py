"""The output of `plumbob validate`: the unexpected first, a table a scene, and the summary last."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement, reference_run, worst
from plumbob.engines.study.results import Study
from plumbob.engines.study.runner import pairs
from plumbob.models.scene import Quantity, Scene
from plumbob.reports.judge.expectations import Standing, expected, standing, surprise
from plumbob.reports.judge.searches import judged_searches, unexpected
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.view import notation


def unexpected_lines(study: Study, judged: Judgements) -> Iterator[str]:
    """The unexpected verdicts: scene, method, verdict, what was expected, and why; then those on
    largest steps and derivatives."""
    for scene, method in pairs(study.scenes, study.methods):
        judgement = judged[scene.name, method.name].whole
        if standing(scene, method, judgement) != "unexpected":
            continue
        wanted = expected(scene.name, method.name)
        yield f"UNEXPECTED {scene.name} {method.name}: {surprise(scene, method, judgement)}"
        yield f"  {judgement.reason or 'every error is within its tolerance'}"
        if wanted.reason:
            yield f"  declared: {wanted.reason}"
    for of in unexpected(judged_searches(study)):
        yield f"UNEXPECTED {of.scene} {of.method}: {of.about}, {of.surprise}"


def scene_lines(
    scene: Scene, study: Study, judged: Judgements, verbose: bool = False
) -> Iterator[str]:
    """The table of one scene, a row a method; with `verbose` every reason, the confidence interval
    of every order, and the cost of a step too."""
    chosen = [method for _, method in pairs((scene,), study.methods)]
    if not chosen:
        return
    ran = {c.method: c for c in study.convergence if c.scene == scene.name}
    about = study.quantities(scene.name)
    of = f" of {about[0].observable}" if len(about) == 1 else ""
    heads = [
        "method",
        "verdict",
        f"relative error{of}",
        "at",
        "order",
        "real time",
        *(["cost of a step", "smallest", "at"] if verbose else []),
    ]
    rows = [_row(scene, m, ran[m.name], study, judged, about, verbose) for m in chosen]
    lines = aligned([heads, *rows])
    yield f"{scene.name}: {scene.summary}" if verbose else scene.name
    yield f"  {next(lines)}"
    for method, line in zip(chosen, lines, strict=True):
        yield f"  {line}"
        if verbose:
            judgement = judged[scene.name, method.name].whole
            yield from (f"      {reason}" for reason in (judgement.reason,) if reason)
            yield from (f"      not judged: {n}, {why}" for n, why in judgement.unjudged.items())


def summary_lines(study: Study, judged: Judgements, page: Path) -> Iterator[str]:
    """The last lines: runs, verdicts, known limits, unexpected verdicts, and where the page is."""
    means: Counter[Standing] = Counter()
    verdicts: Counter[str] = Counter()
    for scene, method in pairs(study.scenes, study.methods):
        judgement = judged[scene.name, method.name].whole
        means[standing(scene, method, judgement)] += 1
        verdicts[judgement.verdict] += 1
    runs = sum(m.status in ("done", "diverged") for c in study.convergence for m in c.measurements)
    for of in judged_searches(study):
        means["unexpected"] += bool(of.surprise)
        means["known limit"] += bool(of.known and not of.surprise)
    counted = ", ".join(f"{count} {verdict}" for verdict, count in verdicts.most_common())
    if verdicts["predicted"]:
        yield "predicted: the error is what theory predicts; how large it is stands beside"
    judgements = notation.plural(verdicts.total(), "verdict")
    yield f"{notation.plural(runs, 'run')}, {judgements}: {counted}"
    limits = notation.plural(means["known limit"], "known limit")
    yield f"{limits}, {means['unexpected']} unexpected"
    yield f"page: {page}"


def _row(
    scene: Scene,
    method: Method,
    ran: ConvergenceStudy,
    study: Study,
    judged: Judgements,
    about: Sequence[Quantity],
    verbose: bool,
) -> list[str]:
    """The cells of one method: its relative error at the reference step, and what that costs."""
    result, cost = judged[scene.name, method.name].whole, study.costs.get((scene.name, method.name))
    means = standing(scene, method, result)
    mark = {"known limit": " (known)", "unexpected": " (UNEXPECTED)"}.get(means, "")
    cells = [method.name, f"{result.verdict}{mark}", "", "", "", ""]
    if shown := reference_run(ran.measurements, method):
        cells[2], cells[3] = _error(shown, about), notation.step(shown.step, method.control)
        if cost and shown.duration:
            cells[5] = notation.times_real(cost.ns_per_step * shown.steps / shown.duration)
    if ran.order:
        cells[4] = f"{ran.order.slope:.2f}"
        if verbose:
            cells[4] += f" ({ran.order.low:.2f} to {ran.order.high:.2f})"
    if not verbose:
        return cells
    best = min(result.errors, key=lambda step: result.errors[step], default=None)
    least = ["", ""]
    if best:
        least = [notation.number(result.errors[best], 2), notation.step(best, method.control)]
    return [*cells, f"{cost.ns_per_step:.0f} ns" if cost else "", *least]


def _error(run: Measurement, about: Sequence[Quantity]) -> str:
    """The relative error of a run, with its quantity where a scene is about several."""
    quantity, error = worst(run, about)
    of = f" ({quantity.observable})" if len(about) > 1 else ""
    return f"{notation.number(error, 2)}{of}" if math.isfinite(error) else "–"


def aligned(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Rows of cells as lines whose columns are below one another."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for cells in rows:
        padded = (f"{cell:<{width}}" for cell, width in zip(cells, widths, strict=True))
        yield "  ".join(padded).rstrip()
