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
    *("projectile", "incline", "rolling-ball", "rolling-disc", "bouncing-ball", "pinch", "stack"),
    *("n-pendulum", "slider-crank", "four-bar", "servo", "heavy-top", "rod-impact"),
)


def phenomena(study: Study, every: Results, systems: Sequence[SystemRecord]) -> Table | None:
    """A row a system of the canon, a column an engine: of the engine's method whose largest error
    at 1 ms over its scenes is the smallest, that error, and the largest of the smallest errors of
    its runs; None where no scene of the canon was run."""
    titles = {system.name: system.title for system in systems}
    names = [name for name in engines(study) if name != "exact"]
    ran: dict[str, dict[str, dict[str, list[MethodResult]]]] = {}
    for of in every.values():
        if of.at_reference and not of.method.surrogate:
            by_engine = ran.setdefault(of.scene.system, {}).setdefault(of.method.engine, {})
            by_engine.setdefault(of.name, []).append(of)
    rows = {
        (titles[system], system): [_cell(ran[system].get(engine, {})) for engine in names]
        for system in CANON
        if system in titles and system in ran
    }
    return table_or_none("phenomena", rows=rows, names=names)


def _cell(ran: Mapping[str, Sequence[MethodResult]]) -> str:
    """Of an engine's methods that do the most of a system's scenes, those first that are as
    predicted or converge on all; empty where the engine has none."""
    most = max(map(len, ran.values()), default=0)
    best = min(((*_order(of), name) for name, of in ran.items() if len(of) == most), default=None)
    if best is None:
        return ""
    _, error, name = best
    smallest = max(min(of.errors.values()) for of in ran[name])
    method = name.partition("/")[2]
    return f"{notation.relative(error)}, {notation.relative(smallest)}; {method}"


def _order(results: Sequence[MethodResult]) -> tuple[bool, float]:
    """Sorts methods without limits first, then small errors."""
    shown = [at for of in results if (at := of.at_reference)]
    limited = any(at.meaning not in ("predicted", "converges") for at in shown)
    return limited, max(at.error for at in shown)
