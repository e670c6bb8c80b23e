"""Is it within tolerance: verdicts, recommendations, the page and the command line."""

from __future__ import annotations

from reports.check import check

__all__ = ["check"]
