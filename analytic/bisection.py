"""Bisection between a number that holds and a number that fails."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

Midpoint = TypeVar("Midpoint", int, float)
Holds = Callable[[Midpoint], bool]


def bisected(
    holds: Holds[Midpoint],
    held: Midpoint,
    failed: Midpoint,
    middle: Callable[[Midpoint, Midpoint], Midpoint | None],
) -> tuple[Midpoint, Midpoint]:
    """The largest number that holds and the smallest number that fails, of those tried between two
    numbers of which one `held` and one `failed`. The search ends where two numbers have no
    `middle`."""
    while (between := middle(held, failed)) is not None:
        if holds(between):
            held = between
        else:
            failed = between
    return held, failed
