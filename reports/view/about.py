"""Descriptions of the systems for the readers of their pages: sentences, equations and symbols."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from plumbob.reports.view.finding_text import read_keys
from plumbob.reports.view.tables import TABLE_TEMPLATES, TemplateParts, fill_text

Description = Mapping[str, Sequence[Sequence[str]]]
"""Lines of a description by their kind; each line is the sequence of its parts. The kinds are
`sentence`; `short`, a sentence for the index in place of the first one; `equation`, in Unicode;
`explained`, the meaning of the equations and their source; and `symbol`, with its meaning and SI
unit. The model's picture, 480 by 360, has the kinds `label`, with its position; `line`, an SVG path
and its class; and `picture`, the picture in words."""


def read_description(system: str) -> Description | None:
    """Returns the description of a system by its name; None if it has none."""
    if not (TABLE_TEMPLATES / "about" / f"{system}.md").is_file():
        return None
    lines = read_keys(fill_text(f"about/{system}", TemplateParts(), {}), system)
    return {kind: [text.split(" | ") for text in texts] for kind, texts in lines.items()}
