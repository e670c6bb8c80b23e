"""Adds shapes to engines that give coefficients of friction and restitution to shapes. A mechanism
gives them to pairs of shapes: a shape with different coefficients in its pairs is added once for
each."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from plumbob.engines.mechanism import Mechanism, Touch

Surface = TypeVar("Surface")
Copy = TypeVar("Copy")


def add_shape_copies(
    mechanism: Mechanism,
    surface_of: Callable[[Touch], Surface],
    add: Callable[[int, Surface], Copy],
) -> list[tuple[Copy, Copy]]:
    """Adds all shapes that can touch to an engine, and returns the two copies of each pair.

    `surface_of` returns the coefficients of a pair of shapes. `add` adds the shape with a number,
    with these coefficients, and returns the engine's name of that copy."""
    copies: dict[tuple[int, Surface], Copy] = {}
    pairs = []
    for touch in mechanism.touching:
        surface = surface_of(touch)
        for number in touch.shapes:
            if (number, surface) not in copies:
                copies[number, surface] = add(number, surface)
        first, second = touch.shapes
        pairs.append((copies[first, surface], copies[second, surface]))
    return pairs
