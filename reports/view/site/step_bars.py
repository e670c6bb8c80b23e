"""Bars of steps, from accurate to stable to lost, as SVG."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from html import escape

from plumbob.reports.view.axis import Axis
from plumbob.reports.view.step_ranges import StepRange

WIDTH, ROW, THICK, FOOT = 440, 34, 10, 34  # of the figure, in its own units
ACCURATE, STABLE = 0.9, 0.35  # opacities of two parts of a bar; the third is an outline


def step_bars(ranges: Sequence[StepRange]) -> str:
    """A bar a method with a known limit as an SVG element, from accurate to stable to lost; empty
    where no limit is finite."""
    shown = [of for of in ranges if of.limit is not None]
    finite = [of.limit.step for of in shown if of.limit and 0.0 < of.limit.step < math.inf]
    if not finite:
        return ""
    ends = [*finite, *(of.accurate for of in shown if of.accurate)]
    across = Axis(math.log10(min(ends) / 4.0), math.log10(max(ends) * 2.0), 8.0, WIDTH - 8.0, True)
    height = ROW * len(shown) + FOOT
    label = "The steps of each method that are accurate and stable. "
    label += "; ".join(f"{of.method}: {of.text}" for of in shown)
    rows = "".join(mark for i, of in enumerate(shown) for mark in _bar(of, ROW * i, across))
    ticks = "".join(
        f'<text x="{x:.1f}" y="{height - 18}" class="m">{text}</text>'
        for x, text in across.ticks(4)
    )
    return (
        f'<svg class="picture" viewBox="0 0 {WIDTH} {height}" role="img" '
        f'aria-label="{escape(label)}">{rows}{ticks}'
        f'<text x="{WIDTH / 2:.0f}" y="{height - 3}" class="m">step [s]</text></svg>'
    )


def _bar(of: StepRange, top: int, across: Axis) -> Iterator[str]:
    """The label of a bar, and its three parts."""
    assert of.limit is not None
    low, high = across.start, across.end
    stable = min(across.at(of.limit.step), high) if 0.0 < of.limit.step < math.inf else high
    stable = stable if of.limit.step else low
    accurate = min(across.at(of.accurate), stable) if of.accurate else low
    yield f'<text x="{low}" y="{top + 14}">{escape(f"{of.method}: {of.text}")}</text>'
    for start, end, fill in (
        (low, accurate, f'fill="currentColor" fill-opacity="{ACCURATE}"'),
        (accurate, stable, f'fill="currentColor" fill-opacity="{STABLE}"'),
        (stable, high, 'fill="none" stroke="currentColor" stroke-dasharray="3 3"'),
    ):
        if end > start:
            box = f'x="{start:.1f}" y="{top + 19}" width="{end - start:.1f}" height="{THICK}"'
            yield f"<rect {box} {fill}/>"
