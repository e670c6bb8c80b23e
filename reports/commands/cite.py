"""plumbob cite: how to cite the suite and the sources of its systems."""

from __future__ import annotations

import argparse

from plumbob import __version__
from plumbob.models.registry import systems


def command(chosen: argparse.Namespace) -> int:
    """Prints how to cite plumbob, then each source once with the systems that are taken from it."""
    print(f"plumbob, version {__version__}: a cross-validation suite for physics engines.")
    titles: dict[str, list[str]] = {}
    for system in systems().values():
        for source in dict.fromkeys(scene.source for scene in system.scenes):
            titles.setdefault(source, []).append(system.title)
    for source, cited_by in titles.items():
        print(f"\n{'; '.join(cited_by)}:\n  {source}")
    return 0
