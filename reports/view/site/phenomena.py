"""The table of canonical phenomena by engine: the engine's best method and its errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from plumbob.engines.study.results import Study
from plumbob.reports.view import notation
from plumbob.reports.view.content import Table
from plumbob.reports.view.method_results import MethodResult, Results
from plumbob.reports.view.records import SystemRecord
from plumbob.reports.view.site.matrix import engines
from plumbob.reports.view.tables import table_or_none

CANON = (
    *(
        "projectile",
        "incline",
        "rolling-ball",
        "rolling-disc",
        "bouncing-ball",
        "pinch",
        "stack",
    ),
    *("n-pendulum", "slider-crank", "four-bar", "servo", "heavy-top", "rod-impact"),
)


def phenomena(study: Study, every: Results, systems: Sequence[SystemRecord]) -> Table | None:
    """Returns the table with a row for each system of `CANON` and a column for each engine; None if
    no scene of these systems was run.

    A cell shows the best method of the engine for the system, with two relative errors: the largest
    error over the scenes at 1 ms, and the largest over the scenes of the smallest error at any
    step."""
    names = [name for name in engines(study) if name != "exact"]
    ran: dict[tuple[str, str], dict[str, list[MethodResult]]] = {}
    for of in every.values():
        if of.at_reference and not of.method.surrogate:
            methods = ran.setdefault((of.scene.system, of.method.engine), {})
            methods.setdefault(of.name, []).append(of)
    titles = {of.name: of.title for of in systems if any(of.name in pair for pair in ran)}
    rows = {
        (titles[system], system): [_cell(ran.get((system, engine), {})) for engine in names]
        for system in CANON
        if system in titles
    }
    return table_or_none("phenomena", rows=rows, names=names)


def _cell(ran: Mapping[str, Sequence[MethodResult]]) -> str:
    """Returns the text of one cell, for the best of an engine's methods on one system; empty if the
    engine has none. `ran` holds each method's results on the scenes of the system.

    Only the methods that ran the most scenes are compared. A method that is as predicted or
    converges on all its scenes precedes every other; after that, the method whose largest error at
    the reference step is the smallest comes first."""
    most = max(map(len, ran.values()), default=0)
    ranks = []
    for name, results in ran.items():
        shown = [at for of in results if (at := of.at_reference)]
        limited = any(at.meaning not in ("predicted", "converges") for at in shown)
        ranks.append((len(results) < most, limited, max(at.error for at in shown), name))
    if not ranks:
        return ""
    *_, error, name = min(ranks)
    smallest = max(min(of.errors.values()) for of in ran[name])
    return (
        f"{notation.relative(error)}, {notation.relative(smallest)}; {name.partition('/')[2]}"
    )
