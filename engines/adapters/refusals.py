"""Names the features of a mechanism that engines for trees of rigid bodies cannot express."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from plumbob.engines.method import Unsupported

if TYPE_CHECKING:  # imported only for types: `plumbob list` needs no records of mechanisms
    from plumbob.engines.mechanism import Mechanism, Touch


def refuse(features: Iterable[str]) -> None:
    """Raises Unsupported with the name of the first of these features, if there is one."""
    for feature in features:
        raise Unsupported(f"feature {feature}")


def refused_parts(mechanism: Mechanism) -> Iterator[str]:
    """Names the parts of a model for which a mechanism has no record, and bodies whose weight is
    partly carried."""
    yield from (part.name for part in mechanism.not_expressed)
    for body in mechanism.bodies:
        if body.carried not in (0.0, 1.0):
            yield f"partly carried weight of body {body.name}"


def refused_weights(mechanism: Mechanism) -> Iterator[str]:
    """Names the bodies whose weight is carried, in part or in full."""
    yield from (
        f"carried weight of body {body.name}" for body in mechanism.bodies if body.carried
    )


def names_of(mechanism: Mechanism, touch: Touch) -> str:
    """The names of two shapes, such as "left foot and floor"."""
    return " and ".join(_name(mechanism, number) for number in touch.shapes)


def _name(mechanism: Mechanism, number: int) -> str:
    """The name of the shape with this number. If the shape has no name, it is the name of its body;
    if the body has none either, it is the kind of the shape."""
    shape = mechanism.shapes[number]
    return shape.name or mechanism.bodies[shape.body].name or f"a {shape.kind}"


def refused_shapes(mechanism: Mechanism) -> Iterator[str]:
    """Names the convex hulls of a mechanism."""
    yield from (f"hull {shape.name}" for shape in mechanism.shapes if shape.kind == "hull")


def refused_friction(touch: Touch, names: str) -> Iterator[str]:
    """Names the features of the friction between two shapes, called `names`, beyond one
    coefficient."""
    yield from refused_turning(touch, names)
    yield from refused_directions(touch, names)


def refused_turning(touch: Touch, names: str) -> Iterator[str]:
    """Names torsional or rolling friction between two shapes, called `names`, if there is any."""
    if touch.torsional or any(touch.rolling):
        yield f"torsional or rolling friction of {names}"


def refused_directions(touch: Touch, names: str) -> Iterator[str]:
    """Names friction between two shapes, called `names`, that depends on the direction, if it
    does."""
    if touch.sliding[0] != touch.sliding[1] or touch.rolling[0] != touch.rolling[1]:
        yield f"friction of {names}, different along two directions"
