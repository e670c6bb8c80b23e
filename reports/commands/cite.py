"""plumbob cite: what to cite: the suite, and the sources of its systems."""

from __future__ import annotations

import argparse

from models.registry import systems
from reports.version import version


def arguments(parser: argparse.ArgumentParser) -> None:
    """The command takes none."""


def command(chosen: argparse.Namespace) -> int:
    """Print the suite's own entry, then each source once."""
    print(f"plumbob, version {version()}: a cross-validation suite for physics engines.")
    sources = {
        scene.source: system.title for system in systems().values() for scene in system.scenes
    }
    for source, title in sources.items():
        print(f"\n{title}:\n  {source}")
    return 0
