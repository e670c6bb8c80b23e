"""Bisection between a number that holds and a number that fails."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T", int, float)
Holds = Callable[[T], bool]


def bisected(
    holds: Holds[T], held: T, failed: T, middle: Callable[[T, T], T | None]
) -> tuple[T, T]:
    """The largest number that holds and the smallest number that fails, of those tried between two
    numbers of which one `held` and one `failed`. The search ends where two numbers have no
    `middle`."""
    while (between := middle(held, failed)) is not None:
        if holds(between):
            held = between
        else:
            failed = between
    return held, failed
