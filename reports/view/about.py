"""Descriptions of the systems for the reader of a page: parts, symbols, equation, source."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from plumbob.reports.view.finding_text import keys_of
from plumbob.reports.view.tables import TEMPLATES, Parts, filled_text

Description = Mapping[str, Sequence[Sequence[str]]]
"""Lines by what they are, each as its parts: `sentence`; `equation`, in Unicode; `explained`, what
the equations say, and from where; `symbol`, with its meaning and SI unit; of the model's picture,
480 by 360, `label` with its place, `line`, an SVG path and its class, `picture` in words."""


def described(system: str) -> Description | None:
    """The description of a system by its name; None where there is none."""
    if not (TEMPLATES / "about" / f"{system}.md").is_file():
        return None
    lines = keys_of(filled_text(f"about/{system}", Parts(), {}), system)
    return {kind: [text.split(" | ") for text in texts] for kind, texts in lines.items()}
