"""plumbob sources: every statement of the three papers, and by what it is computed."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from plumbob.reports.commands.arguments import values
from plumbob.reports.view.sources import SOURCES, listed
from plumbob.reports.view.tables import lines


def command(chosen: argparse.Namespace) -> int:
    """Print the statements by place, each with its finding and its second method."""
    if chosen.json:
        values.print_json([asdict(entry) for entry in listed()])
    else:
        print(*lines("sources", rows=listed(), sources=SOURCES), sep="\n")
    return 0
