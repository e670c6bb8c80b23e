"""plumbob sweep: methods over a grid of parameters: maps of the error, and the worst points."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from plumbob.engines.registry import method as find_method
from plumbob.reports.commands.arguments import values

INCOMPLETE = 3

if TYPE_CHECKING:
    pass


def command(chosen: argparse.Namespace) -> int:
    """Run what is not stored yet, print the errors, write the page."""
    from plumbob.engines.box import box
    from plumbob.engines.study.provenance import provenance
    from plumbob.engines.sweep import store
    from plumbob.engines.sweep.sweep import sweep, sweep_of
    from plumbob.reports.commands.arguments.console import progress
    from plumbob.reports.view.own_files import check_replaceable
    from plumbob.reports.view.sweep.page import page_name, write_sweep_page
    from plumbob.reports.view.sweep.text import terminal_values

    sides, counts = zip(*chosen.vary, strict=True)
    methods = [find_method(name) for name in dict.fromkeys(chosen.method)]
    steps = list(dict.fromkeys(chosen.step or [values.default_step(methods[0])]))
    with values.representable(chosen.changes):
        around = box(chosen.scene, chosen.changes, sides)
    asked = sweep_of(around, counts, methods, steps)
    out = Path(chosen.out)
    key = store.key_of_sweep(asked)
    check_replaceable("out", out / page_name(asked, key))
    with (
        values.workers(chosen) as (executor, jobs),
        progress() as show,
        store.keeping(out / store.FILE, asked) as (there, keep),
    ):
        swept = sweep(
            asked, there, keep, jobs, executor, lambda n, of: show(asked.box.scene, n, of)
        )
    page = write_sweep_page(swept, out, provenance(chosen.line), key)
    for number, why in swept.lost.items():
        print(
            f"plumbob: points from {number * asked.chunk} on are missing: {why}",
            file=sys.stderr,
        )
    texts = terminal_values(swept)
    record = {
        "scene": texts["scene"],
        "points": asked.points,
        "rows": texts["rows"],
        "without_error": swept.reasons,
        "page": str(page),
    }
    stored = min(len(there) * asked.chunk, asked.points)
    values.show(chosen, record, "sweep", **texts, stored=stored, page=page)
    return INCOMPLETE if swept.lost else 0
