"""Is it within tolerance: verdicts, recommendations, the page and the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from reports.assertion import check

__all__ = ["check"]


def __getattr__(name: str) -> Any:
    """`check`, loaded when it is asked for: the command line has to look round first."""
    if name == "check":
        from reports.assertion import check

        return check
    raise AttributeError(f"module 'reports' has no attribute {name!r}")
