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
    """Returns the largest number tried that holds and the smallest that fails, between two numbers
    of which one `held` and one `failed`. The search ends when two numbers have no `middle`."""
    while (between := middle(held, failed)) is not None:
        if holds(between):
            held = between
        else:
            failed = between
    return held, failed
