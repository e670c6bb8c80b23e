"""Features of a mechanism that engines of trees of rigid bodies cannot express, by name."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # this module is loaded at each start, records of mechanisms are not
    from plumbob.engines.mechanism import Mechanism, Touch


def refused_parts(mechanism: Mechanism) -> Iterator[str]:
    """The names of parts that a mechanism has no record of, and of bodies whose weight is partly
    carried."""
    yield from (part.name for part in mechanism.not_expressed)
    for body in mechanism.bodies:
        if body.carried not in (0.0, 1.0):
            yield f"partly carried weight of body {body.name}"


def names_of(mechanism: Mechanism, touch: Touch) -> str:
    """The names of two shapes; of a shape without a name that of its body."""
    return " and ".join(_name(mechanism, number) for number in touch.shapes)


def _name(mechanism: Mechanism, number: int) -> str:
    """The name of a shape by its number, else that of its body, else what both are."""
    shape = mechanism.shapes[number]
    return shape.name or mechanism.bodies[shape.body].name or f"a {shape.kind}"


def refused_shapes(mechanism: Mechanism) -> Iterator[str]:
    """The names of hulls."""
    yield from (f"hull {shape.name}" for shape in mechanism.shapes if shape.kind == "hull")


def refused_friction(touch: Touch, names: str) -> Iterator[str]:
    """The names of what friction between two shapes, called `names`, has beside one coefficient."""
    yield from refused_turning(touch, names)
    yield from refused_directions(touch, names)


def refused_turning(touch: Touch, names: str) -> Iterator[str]:
    """The name of friction between two shapes, called `names`, that resists turns."""
    if touch.torsional or any(touch.rolling):
        yield f"torsional or rolling friction of {names}"


def refused_directions(touch: Touch, names: str) -> Iterator[str]:
    """The name of friction between two shapes, called `names`, that depends on the direction."""
    if touch.sliding[0] != touch.sliding[1] or touch.rolling[0] != touch.rolling[1]:
        yield f"friction of {names}, different along two directions"
