"""A system described: sentences, the equation of motion, symbols, and labels for its picture."""

from __future__ import annotations

from dataclasses import dataclass

SIZE = (480, 360)  # of the models' pictures, in which labels and lines have their places


@dataclass(frozen=True)
class Label:
    """A symbol in the picture, and where its first letter stands."""

    text: str
    x: float
    y: float


@dataclass(frozen=True)
class Symbol:
    """A symbol, what it stands for, and its SI unit."""

    text: str
    meaning: str
    unit: str = "1"


@dataclass(frozen=True)
class Description:
    """The description of a system at the top of its page, before any result."""

    sentences: tuple[str, str]
    equations: tuple[str, ...]  # one a line, in Unicode
    explained: str  # what the equations say, and from where
    symbols: tuple[Symbol, ...]
    labels: tuple[Label, ...] = ()
    lines: tuple[str, ...] = ()  # SVG paths over the picture
    alternative: str = ""  # the picture in words


def capsule_labels(*more: Label) -> tuple[Label, ...]:
    """The labels that every motion of the capsule shares, and more."""
    return (
        Label("A₁", 383, 222),
        Label("A₂", 231, 98),
        Label("A₃", 30, 186),
        Label("C", 199, 158),
        Label("Q", 272, 168),
        *more,
    )
