"""The canon's phenomena against engines: which method has the smallest error, and how small."""

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
    """A row a system of the canon, a column an engine: of the engine's method whose largest error
    at 1 ms over its scenes is the smallest, that error, and the largest of the smallest errors of
    its runs; None where no scene of the canon was run."""
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
    """Of an engine's methods that do the most of a system's scenes, those first that are as
    predicted or converge on all, and then small errors; empty where the engine has none."""
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
