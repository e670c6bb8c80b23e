"""The suite's own version."""

from __future__ import annotations

from importlib import metadata


def version() -> str:
    """Version of the installed distribution, or `unknown` in a bare checkout."""
    try:
        return metadata.version("plumbob")
    except metadata.PackageNotFoundError:
        return "unknown"
