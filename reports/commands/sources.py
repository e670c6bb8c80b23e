"""plumbob sources: every statement of the three papers, and what computes it."""

from __future__ import annotations

import argparse

from plumbob.reports.commands.arguments import values
from plumbob.reports.view.sources import CITED_SOURCES, listed_statements


def command(chosen: argparse.Namespace) -> int:
    """Prints the statements in the order of their places in the papers, each with its finding and
    its second method."""
    values.show(
        chosen, listed_statements(), "sources", rows=listed_statements(), sources=CITED_SOURCES
    )
    return 0
