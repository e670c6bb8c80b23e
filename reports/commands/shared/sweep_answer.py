"""Answer of a command that runs or merges a sweep: the page and the errors."""

from __future__ import annotations

import argparse
from pathlib import Path

from plumbob.engines.study.provenance import provenance
from plumbob.engines.sweep.sweep import Swept
from plumbob.reports.columns.sweep_columns import point_columns
from plumbob.reports.commands.arguments import values
from plumbob.reports.view.sweep.page import write_sweep_page
from plumbob.reports.view.sweep.text import terminal_values


def print_sweep(chosen: argparse.Namespace, swept: Swept, key: str, stored: int) -> None:
    """Writes the page of a sweep with this `key` and prints the errors. So many points were
    `stored` before the command began."""
    page = write_sweep_page(swept, Path(chosen.out), provenance(chosen.line), key)
    texts = terminal_values(swept)
    record = {
        "scene": texts["scene"],
        "points": swept.sweep.points,
        "rows": texts["rows"],
        "without_error": swept.reasons,
        "page": str(page),
    }
    texts |= {"stored": stored, "page": page}
    values.show(chosen, record, "sweep", columns=lambda: point_columns(swept), **texts)
