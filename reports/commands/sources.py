"""plumbob sources: every statement of the three papers, and by what it is computed."""

from __future__ import annotations

import argparse

from plumbob.reports.commands.arguments import values
from plumbob.reports.view.sources import SOURCES, listed_statements


def command(chosen: argparse.Namespace) -> int:
    """Print the statements by place, each with its finding and its second method."""
    values.show(
        chosen, listed_statements(), "sources", rows=listed_statements(), sources=SOURCES
    )
    return 0
