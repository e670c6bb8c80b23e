"""The search for the largest step that holds."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T", int, float)


def bisected(
    holds: Callable[[T], bool], held: T, failed: T, middle: Callable[[T, T], T | None]
) -> tuple[T, T]:
    """The largest number that holds and the smallest one that fails, of those tried between two
    numbers of which one `held` and one `failed`; the search ends where the two have no `middle`."""
    while (between := middle(held, failed)) is not None:
        if holds(between):
            held = between
        else:
            failed = between
    return held, failed
