"""The entries of the search in a page's header, from topics and engines to commands and terms."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from plumbob.reports.view.tables import paragraphs

SearchTerms = Sequence[tuple[str, str]]  # (term, meaning)


def defined_terms(template: str) -> SearchTerms:
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
    """Yields the kind, name, text and address of each search entry. The text of a topic or of an
    engine is a list of words that a reader may search for."""
    for name, place, words in _topics(common):
        yield "topic", name, words, href(place)
    for engine, methods in common["sides"].names.items() if common["sides"] else ():
        other = "mujoco" if engine != "mujoco" else "pymunk"
        address = f"{href('side-by-side')}?a={engine}&b={other}"
        yield "engine", common["engines"].get(engine, engine), ", ".join(methods), address
    for view in common["views"]:
        yield "system", view.system.title, view.system.name, href(view.system.name)
        for scene_view in view.scenes:
            scene = scene_view.scene
            yield "scene", scene.name, scene.summary, href(scene_view.anchor)
    for finding in common["findings"]:
        yield "finding", finding.title, finding.summary, href(finding.name)
    for method in common["study"].methods:
        yield "method", method.name, "", f"{href('matrix')}?filter={method.name}"
    for name, does in common["commands"]:
        yield "command", name, does, href(term_id(name))
    for term, meaning in (*common["terms"], *common["labels"]):
        yield "term", term, meaning, href(term_id(term))


def _topics(common: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Yields the name, the id and the synonyms of each topic that the study's pages have a place
    for."""
    places = {"kind-own", *(f"kind-{kind.name}" for kind in common["kinds"])}
    places |= {view.system.name for view in common["views"]} | {"matrix"}
    shown = {"side-by-side": "sides", "largest-step": "largest_step", "gradients": "gradients"}
    places |= {place for place, value in shown.items() if common[value]}
    for name, rest in defined_terms("topics"):
        place, _, words = rest.partition(": ")
        if place in places and (common["kinds"] or not place.startswith("kind-")):
            yield name, place, words
