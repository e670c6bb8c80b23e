"""plumbob sources: every statement of the three papers, and what computes it."""

from __future__ import annotations

import argparse

from plumbob.reports.commands.arguments import values
from plumbob.reports.view.sources import SOURCES, listed


def command(chosen: argparse.Namespace) -> int:
    """Prints the statements in the order of their places in the papers, each with its finding and
    its second method."""
    values.show(chosen, listed(), "sources", rows=listed(), sources=SOURCES)
    return 0
