"""A page read by a test, without running its scripts."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from typing import Any


class Document(HTMLParser):
    """Parts of a page for tests: ids, links, loaded files, plots, and the text of tables."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.scripts: list[str] = []
        self.figures: list[dict[str, Any]] = []
        self.cells: list[str] = []
        self.tags: list[str] = []
        self._inside = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.tags.append(tag)
        self.ids += [given["id"] or ""] if "id" in given else []
        self.links += [given["href"] or ""] if tag == "a" else []
        self.loaded += [given[name] or "" for name in ("src", "srcset", "data") if name in given]
        self.loaded += [given["href"] or ""] if tag == "link" else []
        self._inside = "json" if given.get("type") == "application/json" else tag
        if tag == "td":
            self.cells.append("")

    def handle_endtag(self, tag: str) -> None:
        self._inside = "td" if tag in ("a", "span", "svg") and self._inside != "" else ""

    def handle_data(self, data: str) -> None:
        if self._inside == "json":
            found = json.loads(data)
            for trace in found["data"]:
                trace |= {axis: found["arrays"][trace[axis]] for axis in "xy"}
            self.figures.append(found)
        elif self._inside == "script":
            self.scripts.append(data)
        elif self.cells:
            self.cells[-1] += data
