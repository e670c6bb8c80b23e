"""The beginning of a scene's page: sentences on what to expect and to use, and every error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import relative_error
from plumbob.engines.study.results import Quantities
from plumbob.reports.advice.recommend import DEFAULT_METHOD, Recommendation
from plumbob.reports.advice.work_precision import Point
from plumbob.reports.view.content import Table
from plumbob.reports.view.records import PairVerdict
from plumbob.reports.view.site.matrix import Shown, Steps
from plumbob.reports.view.tables import paragraphs, table

WANTED = 1e-3  # relative: the error that a method is recommended for

Series = Sequence[ConvergenceStudy]
Cells = Mapping[str, Steps]  # by method


def sentences(
    series: Series, about: Quantities, cells: Cells, advice: Sequence[Recommendation]
) -> tuple[str, ...]:
    """The error of MuJoCo's default settings, the method to use and its cost, and for both whether
    a smaller step helps."""
    return paragraphs(
        "scene",
        default=DEFAULT_METHOD,
        of_engine=[name for name in cells if name.startswith("mujoco/")],
        cells=cells,
        finest={c.method: of for c in series if (of := _finest(c, about))},
        orders={c.method: c.order.slope for c in series if c.order},
        answer=next((answer for answer in advice if answer.error == WANTED), None),
    )


def errors(
    series: Series,
    cells: Cells,
    judged: Mapping[str, PairVerdict],
    points: Sequence[Point],
    methods: Mapping[str, Method],
) -> Table:
    """Error, verdict and cost of each method at the reference step."""
    costs = {(point.method, point.step): point.ns_per_second for point in points}
    shown = {c.method: cells[c.method][0] if c.method in cells else None for c in series}
    return table(
        "scene_errors",
        shown=shown,
        judged=judged,
        costs={name: of and costs.get((name, of.step)) for name, of in shown.items()},
        orders={c.method: c.order for c in series if methods[c.method].control == "step"},
    )


def _finest(series: ConvergenceStudy, about: Quantities) -> Shown | None:
    """The error at the smallest step that reached the end; None where no run did."""
    done = [m for m in series.measurements if m.status == "done"]
    return Shown(relative_error(done[-1], about), done[-1].step, "step") if done else None
