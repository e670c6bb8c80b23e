"""plumbob cite: how to cite the suite and the sources of its systems."""

from __future__ import annotations

import argparse
from dataclasses import dataclass

from plumbob import __version__
from plumbob.models.registry import systems

# Sources that are articles, with BibTeX entries of their own.
ARTICLES = ("V. F. Sudakov", "F. L. Chernousko")


@dataclass(frozen=True)
class CitedSource:
    """A source of systems."""

    text: str
    names: tuple[str, ...]  # names of the systems that are taken from it
    titles: tuple[str, ...]  # titles of these systems


def command(chosen: argparse.Namespace) -> int:
    """Prints how to cite plumbob, then each source once with the systems that are taken from it."""
    sources = _sources()
    if chosen.bibtex:
        from plumbob.reports.view.tables import terminal_lines

        others = {s.names[0]: s for s in sources if not s.text.startswith(ARTICLES)}
        print(*terminal_lines("bibtex", version=__version__, others=others), sep="\n")
        return 0
    print(f"plumbob, version {__version__}: a cross-validation suite for physics engines.")
    for source in sources:
        print(f"\n{'; '.join(source.titles)}:\n  {source.text}")
    return 0


def _sources() -> list[CitedSource]:
    """Returns each source once."""
    found: dict[str, dict[str, str]] = {}
    for system in systems().values():
        for text in dict.fromkeys(scene.source for scene in system.scenes):
            found.setdefault(text, {})[system.name] = system.title
    return [CitedSource(text, tuple(by), tuple(by.values())) for text, by in found.items()]
