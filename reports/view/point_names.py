"""Names beside the points of a drawing, each at a place where it covers no point and no other
name."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

from plumbob.reports.view.axis import Axis

LETTER, LINE = (
    9.0,
    19.0,
)  # [px] at most, where a picture is shown smaller and letters are larger
BESIDE = 10.0  # [px] from a point's middle to its name
MARK = 7.0  # [px] from a point's middle to its edge
ROWS = 8  # of names above a point, and below, that are tried


class Name(NamedTuple):
    """A name at a place [px] of a drawing."""

    text: str
    x: float
    y: float  # of the line that letters stand on
    anchor: str  # what of the name lies at x: "" its start, "m" its middle, "e" its end
    # ends [px] of an upright line at x from the point to the name, where other names are nearer
    line: tuple[float, float] | None


Box = tuple[float, float, float, float]  # left, top, right, bottom [px]


def named(points: Sequence[tuple[float, float, str]], x: Axis, y: Axis) -> Sequence[Name]:
    """The names of points (x, y, name) [px] on two axes: beside the point if nothing is there, else
    in the nearest free row above or below it; if no place is free, beside the point."""
    around = (x.start, y.end, x.end, y.start)
    taken = [(a - MARK, b - MARK, a + MARK, b + MARK) for a, b, _ in points]
    names = []
    for point in sorted(points):
        places = list(_places(*point))
        name, box = next(
            (place for place in places if _inside(place[1], around) and _free(place[1], taken)),
            places[0],
        )
        names.append(name)
        taken.append(box)
    return names


def _places(a: float, b: float, text: str) -> Iterator[tuple[Name, Box]]:
    """The places of a name that are tried, each with the box that it covers, the nearest first."""
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
    return (
        box[0] >= around[0]
        and box[1] >= around[1]
        and box[2] <= around[2]
        and box[3] <= around[3]
    )


def _free(box: Box, taken: Sequence[Box]) -> bool:
    """Whether a box overlaps none of those that are taken."""
    return not any(
        box[0] < other[2] and other[0] < box[2] and box[1] < other[3] and other[1] < box[3]
        for other in taken
    )
