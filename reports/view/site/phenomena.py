"""The canon's phenomena against engines: which method has the smallest error, and how small."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.measurement import relative_error
from plumbob.engines.study.results import Study
from plumbob.reports.view import notation
from plumbob.reports.view.content import Table
from plumbob.reports.view.records import SystemRecord
from plumbob.reports.view.site.matrix import Every, Shown, engines
from plumbob.reports.view.tables import table_or_none

CANON = (
    *("projectile", "incline", "rolling-ball", "rolling-disc", "bouncing-ball", "pinch", "stack"),
    *("n-pendulum", "slider-crank", "four-bar", "servo", "heavy-top", "rod-impact"),
)


def phenomena(study: Study, every: Every, systems: Sequence[SystemRecord]) -> Table | None:
    """A row a system of the canon, a column an engine: of the engine's method whose largest error
    at 1 ms over its scenes is the smallest, that error, and the largest of the smallest errors of
    its runs; None where no scene of the canon was run."""
    titles = {system.name: system.title for system in systems}
    names = [name for name in engines(study) if name != "exact"]
    rows = {
        (titles[system], system): [_cell(study, every, system, engine) for engine in names]
        for system in CANON
        if system in titles and any(_of(scene) == system for scene, _ in every)
    }
    return table_or_none("phenomena", rows=rows, names=names)


def _cell(study: Study, every: Every, system: str, engine: str) -> str:
    """Of methods that do the most of the system's scenes, those first that are as predicted or
    converge on all; empty where the engine has none."""
    ran: dict[str, list[Shown]] = {}
    for method in study.methods:
        if method.engine == engine and not method.surrogate:
            wanted = system, method.name
            ran[method.name] = [at for (s, by), (at, *_) in every.items() if (_of(s), by) == wanted]
    most = max(map(len, ran.values()), default=0)
    if not most:
        return ""

    def order(name: str) -> tuple[bool, float]:
        limited = any(at.meaning not in ("predicted", "converges") for at in ran[name])
        return limited, max(at.error for at in ran[name])

    best = min((name for name, cells in ran.items() if len(cells) == most), key=order)
    smallest = max(
        min(relative_error(run, study.quantities(c.scene)) for run in c.measurements)
        for c in study.convergence
        if (c.method, _of(c.scene)) == (best, system) and (c.scene, best) in every
    )
    sizes = notation.relative(order(best)[1]), notation.relative(smallest)
    return f"{sizes[0]}, {sizes[1]}; {best.partition('/')[2]}"


def _of(scene: str) -> str:
    return scene.partition("/")[0]
