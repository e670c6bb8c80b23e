"""Places for the names of points in a drawing, where a name covers no point and no other name."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

from plumbob.reports.view.axis import Axis

# [px] largest width and height of a letter: a picture that is shown smaller has larger letters
LETTER, LINE = (
    9.0,
    19.0,
)
BESIDE = 10.0  # [px] from a point's middle to its name
MARK = 7.0  # [px] from a point's middle to its edge
ROWS = 8  # number of rows tried above a point and below it


class Name(NamedTuple):
    """The name of a point, with its position [px] in the drawing."""

    text: str
    x: float
    y: float  # height of the baseline of the letters
    anchor: str  # part of the name at x: "" the start, "m" the middle, "e" the end
    # ends [px] of the vertical line at x from the point to a distant name; None for a near name
    line: tuple[float, float] | None


Box = tuple[float, float, float, float]  # left, top, right, bottom [px]


def placed_names(
    points: Sequence[tuple[float, float, str]], x: Axis, y: Axis
) -> Sequence[Name]:
    """Returns the placed names of points (x [px], y [px], name) within two axes.

    If the place beside the point is free, the name stands there, else in the nearest free row above
    or below the point. If no place is free, the name stands beside the point."""
    around = (x.start, y.end, x.end, y.start)
    taken = [(a - MARK, b - MARK, a + MARK, b + MARK) for a, b, _ in points]
    names = []
    for point in sorted(points):
        candidates = list(_candidates(*point))
        free = [
            (name, box)
            for name, box in candidates
            if _inside(box, around) and _free(box, taken)
        ]
        name, box = (free or candidates)[0]
        names.append(name)
        taken.append(box)
    return names


def _candidates(a: float, b: float, text: str) -> Iterator[tuple[Name, Box]]:
    """Yields the places to try for the name `text` of a point at (a, b) [px], the nearest first,
    each with the box that the name covers."""
    width = LETTER * len(text)
    for row, side in product(range(ROWS), (-1.0, 1.0)):
        for anchor, start in (("", 0.0), ("e", -1.0), ("m", -0.5)):
            if row == 0 and (anchor == "m" or side > 0.0):
                continue  # the name would cover its own point, or the place was tried
            shift = {"": BESIDE, "e": -BESIDE}.get(anchor, 0.0) if row == 0 else 0.0
            middle = b + side * LINE * row
            left = a + shift + start * width
            line = (b, middle - side * LINE / 2.0) if row > 1 else None
            name = Name(text, a + shift, middle + 4.0, anchor, line)
            yield name, (left, middle - LINE / 2.0, left + width, middle + LINE / 2.0)


def _inside(box: Box, around: Box) -> bool:
    """Returns whether a box lies within the box `around`."""
    return (
        box[0] >= around[0]
        and box[1] >= around[1]
        and box[2] <= around[2]
        and box[3] <= around[3]
    )


def _free(box: Box, taken: Sequence[Box]) -> bool:
    """Returns whether a box overlaps no box in `taken`."""
    return not any(
        box[0] < other[2] and other[0] < box[2] and box[1] < other[3] and other[1] < box[3]
        for other in taken
    )
