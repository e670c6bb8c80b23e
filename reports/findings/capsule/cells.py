"""Numbers as the capsule's tables show them."""

from __future__ import annotations

from plumbob.reports.view.content import Cell
from plumbob.reports.view.notation import number


def value(found: float | None, digits: int = 3) -> Cell:
    """A number; a dash where there is none."""
    return Cell("–" if found is None else number(found, digits), "number")


def method(name: str) -> Cell:
    """A method's name, with its mark on the page's own plots."""
    return Cell(name, "method")


def named(name: str) -> Cell:
    """A method's name beside a figure that has colours of its own."""
    return Cell(name, "name")
