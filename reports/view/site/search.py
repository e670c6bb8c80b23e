"""The entries of the search in a page's header: systems, scenes, methods, findings and terms."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from plumbob.reports.view.tables import paragraphs

Terms = Sequence[tuple[str, str]]  # (term, meaning)


def defined_terms(template: str) -> Terms:
    """Returns the terms and meanings in a template whose paragraphs read `term: meaning`."""
    parted = (text.partition(": ") for text in paragraphs(template))
    return [(term, meaning) for term, _, meaning in parted]


def entries_text(common: Mapping[str, Any], href: Callable[[str], str]) -> str:
    """Returns the search entries as a JSON array of [kind, name, text, address]; `href` returns the
    address of an id."""
    return json.dumps(list(_entries(common, href)), ensure_ascii=False)


def term_id(term: str) -> str:
    """Returns the id of a term on the glossary page."""
    return "term-" + "".join(c if c.isalnum() else "-" for c in term)


def _entries(
    common: Mapping[str, Any], href: Callable[[str], str]
) -> Iterator[tuple[str, str, str, str]]:
    """Yields the kind, name, text and address of each search entry."""
    for view in common["views"]:
        yield "system", view.system.title, view.system.name, href(view.system.name)
        for scene_view in view.scenes:
            scene = scene_view.scene
            yield "scene", scene.name, scene.summary, href(scene_view.anchor)
    for finding in common["findings"]:
        yield "finding", finding.title, finding.summary, href(finding.name)
    for method in common["study"].methods:
        yield "method", method.name, "", f"{href('matrix')}?filter={method.name}"
    for term, meaning in (*common["terms"], *common["labels"]):
        yield "term", term, meaning, href(term_id(term))
