"""The table of canonical phenomena by engine: the engine's best method and its errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from plumbob.engines.study.results import Study
from plumbob.reports.records import notation
from plumbob.reports.records.page_records import SystemRecord
from plumbob.reports.view.content import Table
from plumbob.reports.view.method_results import TRUSTED_MEANINGS, MethodResult, Results
from plumbob.reports.view.site.matrix import engine_names
from plumbob.reports.view.tables import table_or_none


def phenomena(
    study: Study, all_results: Results, systems: Sequence[SystemRecord]
) -> Table | None:
    """Returns the table with a row for each system that is a canonical phenomenon and a column for
    each engine; None if no scene of these systems was run.

    A cell shows the best method of the engine for the system, with two relative errors: the largest
    error over the scenes at 1 ms, and the largest over the scenes of the smallest error at any
    step."""
    names = [name for name in engine_names(study) if name != "exact"]
    ran: dict[tuple[str, str], dict[str, list[MethodResult]]] = {}
    for result in all_results.values():
        if result.at_reference and not result.method.surrogate:
            methods = ran.setdefault((result.scene.system, result.method.engine), {})
            methods.setdefault(result.name, []).append(result)
    systems_that_ran = {system for system, _ in ran}
    shown = [s for s in systems if s.phenomenon and s.name in systems_that_ran]
    shown.sort(key=lambda system: system.phenomenon)
    rows = {
        (system.title, system.name): [
            _cell(ran.get((system.name, engine), {})) for engine in names
        ]
        for system in shown
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
        errors = [result.at_reference for result in results if result.at_reference]
        limited = any(error.meaning not in TRUSTED_MEANINGS for error in errors)
        largest = max(error.error for error in errors)
        ranks.append((len(results) < most, limited, largest, name))
    if not ranks:
        return ""
    *_, error_at_reference, name = min(ranks)
    smallest_error = max(min(result.errors.values()) for result in ran[name])
    return (
        f"{notation.relative(error_at_reference)}, {notation.relative(smallest_error)}; "
        f"{name.partition('/')[2]}"
    )
