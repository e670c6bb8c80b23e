"""The search for the largest step of a grid that holds."""

from __future__ import annotations

from plumbob.analytic.bisection import Holds, bisected

COARSER = 4  # factor by which each stride of a search is wider than the last
# Distances below the largest exponent that holds at which smaller steps must hold, too: steps of
# 0.95, 0.78, 0.5 and 0.25 of a limit. If a search looks only at multiples of a number, all
# multiples within EXPONENTS_NEAR_LIMIT must hold: a motion that becomes chaotic has steps that fail
# below steps that hold.
DROPS_BELOW_LIMIT = (5, 25, 70, 140)
EXPONENTS_NEAR_LIMIT = 25


def bracket(
    holds: Holds[int], first: int, low: int, high: int, every: int = 1
) -> tuple[int | None, int | None]:
    """Returns the largest number that holds, with the numbers tried below it, and the next number,
    which does not hold. The first is None if no number from `low` to `high` holds, the second if
    all do. The search begins at the number `first`, and looks at multiples of `every` before it
    halves the last gap; `first`, `low` and `high` are such multiples."""
    held, failed = _wide_bracket(holds, first, low, high, every)
    if held is None:
        return None, failed
    held, failed = _narrow_bracket(holds, held, failed, every)
    below = {(held - drop) // every * every for drop in DROPS_BELOW_LIMIT}
    if every > 1:
        below |= set(range(held - EXPONENTS_NEAR_LIMIT // every * every, held, every))
    for lower in sorted(below, reverse=True):
        if lower >= low and not holds(lower):
            return bracket(holds, lower, low, lower, every)
    return _narrow_bracket(holds, held, failed, 1)


def _narrow_bracket(
    holds: Holds[int], held: int, failed: int | None, gap: int
) -> tuple[int, int | None]:
    """Returns a number that holds and a larger number that does not, a `gap` apart, from two such
    numbers, `held` and `failed`. If no number fails, `failed` is None, and both are returned as
    they are."""

    def middle(held: int, failed: int) -> int | None:
        """Returns the multiple of the gap halfway between two numbers; None if their distance is a
        gap."""
        return (held + failed) // (2 * gap) * gap if failed - held > gap else None

    return (held, None) if failed is None else bisected(holds, held, failed, middle)


def _wide_bracket(
    holds: Holds[int], first: int, low: int, high: int, stride: int
) -> tuple[int | None, int | None]:
    """Returns a number that holds and a larger number that does not, by ever wider strides from
    `first`. One of them is None if all numbers up to `high` hold, or none down to `low`."""
    up = holds(first)
    last = first
    end = high if up else low
    while last != end:
        following = min(last + stride, end) if up else max(last - stride, end)
        if holds(following) != up:
            return (last, following) if up else (following, last)
        last = following
        stride = COARSER * stride
    return (last, None) if up else (None, last)
