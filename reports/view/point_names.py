"""Places for the names of points in a drawing, where a name covers no point and no other name."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array
from plumbob.reports.view.axis import Axis

# [px] largest width and height of a letter: a picture that is shown smaller has larger letters
LETTER_WIDTH, LETTER_HEIGHT = (
    9.0,
    19.0,
)
NAME_DISTANCE = 10.0  # [px] from a point's middle to its name
MARK_RADIUS = 7.0  # [px] from a point's middle to its edge
ROWS = 8  # number of rows tried above a point and below it


class PointName(NamedTuple):
    """The name of a point, with its position [px] in the drawing."""

    text: str
    x: float
    y: float  # height of the baseline of the letters
    anchor: str  # part of the name at x: "" the start, "m" the middle, "e" the end
    # ends [px] of the vertical line at x from the point to a distant name; None for a near name
    line: tuple[float, float] | None


NameBox = tuple[float, float, float, float]  # left, top, right, bottom [px]


def placed_names(
    points: Sequence[tuple[float, float, str]],
    x: Axis,
    y: Axis,
    ends: Sequence[tuple[float, float, str]] = (),
    curves: npt.ArrayLike = (),
) -> Sequence[PointName]:
    """Returns the placed names of points and of ends of curves (x [px], y [px], name) within two
    axes.

    If the place beside the point is free, the name stands there, else in the nearest free row above
    or below the point. If no place is free of the points of `curves`, shape (n, 2) [px], the name
    may cover curves. If no place is free even so, the name of an end is left out, and the name of
    another point stands beside it."""
    on_curves = np.reshape(np.asarray(curves, dtype=float), (-1, 2))
    around = (x.start, y.end, x.end, y.start)
    taken = [
        (a - MARK_RADIUS, b - MARK_RADIUS, a + MARK_RADIUS, b + MARK_RADIUS)
        for a, b, _ in (*points, *ends)
    ]
    names = []
    for point in sorted((*points, *ends)):
        candidates = list(_candidates(*point))
        free = [c for c in candidates if _inside(c[1], around) and _free(c[1], taken)]
        if not free and point in ends:
            continue
        free = free or candidates
        name, box = next((c for c in free if not _covers(c[1], on_curves)), free[0])
        names.append(name)
        taken.append(box)
    return names


def _candidates(a: float, b: float, text: str) -> Iterator[tuple[PointName, NameBox]]:
    """Yields the places to try for the name `text` of a point at (a, b) [px], the nearest first,
    each with the box that the name covers."""
    width = LETTER_WIDTH * len(text)
    for row, side in product(range(ROWS), (-1.0, 1.0)):
        for anchor, start in (("", 0.0), ("e", -1.0), ("m", -0.5)):
            if row == 0 and (anchor == "m" or side > 0.0):
                continue  # the name would cover its own point, or the place was tried
            shift = (
                {"": NAME_DISTANCE, "e": -NAME_DISTANCE}.get(anchor, 0.0) if row == 0 else 0.0
            )
            middle = b + side * LETTER_HEIGHT * row
            left = a + shift + start * width
            line = (b, middle - side * LETTER_HEIGHT / 2.0) if row > 1 else None
            name = PointName(text, a + shift, middle + 4.0, anchor, line)
            yield (
                name,
                (
                    left,
                    middle - LETTER_HEIGHT / 2.0,
                    left + width,
                    middle + LETTER_HEIGHT / 2.0,
                ),
            )


def _inside(box: NameBox, around: NameBox) -> bool:
    """Returns whether a box lies within the box `around`."""
    return (
        box[0] >= around[0]
        and box[1] >= around[1]
        and box[2] <= around[2]
        and box[3] <= around[3]
    )


def _covers(box: NameBox, points: Array) -> bool:
    """Returns whether a box covers one of the points, shape (n, 2) [px]."""
    inside = (points > box[:2]) & (points < box[2:])
    return bool(inside.all(axis=1).any())


def _free(box: NameBox, taken: Sequence[NameBox]) -> bool:
    """Returns whether a box overlaps no box in `taken`."""
    return not any(
        box[0] < other[2] and other[0] < box[2] and box[1] < other[3] and other[1] < box[3]
        for other in taken
    )
