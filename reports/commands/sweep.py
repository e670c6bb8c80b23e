"""plumbob sweep: run methods over a grid of parameters: maps of the error, and the worst points."""

from __future__ import annotations

import argparse
from pathlib import Path

from plumbob.engines.registry import method as find_method
from plumbob.reports.commands.arguments import values

INCOMPLETE = 3


def command(chosen: argparse.Namespace) -> int:
    """Runs the points that are not stored yet, prints the errors and writes the page. Returns 3 if
    points are missing."""
    from plumbob.engines.box import box
    from plumbob.engines.study.provenance import provenance
    from plumbob.engines.sweep import store
    from plumbob.engines.sweep.sweep import sweep, sweep_of
    from plumbob.reports.columns.sweep_columns import point_columns
    from plumbob.reports.commands.arguments.console import note, progress
    from plumbob.reports.view.own_files import check_replaceable
    from plumbob.reports.view.sweep.page import page_name, write_sweep_page
    from plumbob.reports.view.sweep.text import terminal_values

    sides, counts = zip(*chosen.vary, strict=True)
    methods = [find_method(name) for name in dict.fromkeys(chosen.method)]
    steps = list(dict.fromkeys(chosen.step or [values.default_step(methods[0])]))
    with values.representable(chosen.changes):
        parameter_box = box(chosen.scene, chosen.changes, sides)
    request = sweep_of(parameter_box, counts, methods, steps)
    out = Path(chosen.out)
    key = store.key_of_sweep(request)
    check_replaceable("out", out / page_name(request, key))
    with (
        values.workers(chosen) as (executor, jobs),
        progress() as show,
        store.keeping(out / store.FILE, request) as (stored, keep),
    ):

        def show_chunks(finished: int, total: int) -> None:
            show(request.box.scene, finished, total)

        swept = sweep(request, stored, keep, jobs, executor, show_chunks)
    page = write_sweep_page(swept, out, provenance(chosen.line), key)
    for number, reason in swept.lost.items():
        first_point = number * request.chunk
        note(f"points from {first_point} on are missing: {reason}")
    texts = terminal_values(swept)
    record = {
        "scene": texts["scene"],
        "points": request.points,
        "rows": texts["rows"],
        "without_error": swept.reasons,
        "page": str(page),
    }
    stored_points = min(len(stored) * request.chunk, request.points)
    texts |= {"stored": stored_points, "page": page}
    values.show(chosen, record, "sweep", columns=lambda: point_columns(swept), **texts)
    return INCOMPLETE if swept.lost else 0
