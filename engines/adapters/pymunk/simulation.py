"""A scene as a space of pymunk, and functions that builders share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import pymunk

from plumbob.engines.trajectory import ByName


@dataclass(frozen=True)
class Translation:
    """A scene as a space at its start, with functions to act on it and to read it."""

    space: pymunk.Space
    read: Callable[[], ByName]  # returns the present observables
    act: Callable[[float], None] | None = None
    """Time [s] -> nothing: called before each step, since forces last for one step."""
    limits: ByName = field(default_factory=dict)
    """Magnitudes of observables that only a diverged run exceeds."""
    following: Callable[[], ByName] | None = None
    """Returns the observables of the step that began at a sample, when the step is done."""


def vector(value: complex) -> tuple[float, float]:
    """A vector x + iy of the plane as pymunk takes it."""
    return value.real, value.imag


def touching(
    space: pymunk.Space, body: pymunk.Body, shapes: Sequence[pymunk.Shape], **surface: float
) -> None:
    """Adds a body to a space, with shapes that touch the first of them. pymunk multiplies numbers
    of two surfaces, such as their friction: the first shape has 1, the others have those of
    `surface`."""
    ground, *others = shapes
    for name, value in surface.items():
        setattr(ground, name, 1.0)
        for shape in others:
            setattr(shape, name, value)
    space.add(body, *shapes)


def settle(space: pymunk.Space, step: float, iterations: int) -> None:
    """Lets the solver find the impulses of joints and contacts at the start, in a step that is
    undone. The next step begins with these impulses."""
    usual = space.iterations
    bodies = space.bodies
    start = [(b.position, b.velocity, b.angle, b.angular_velocity) for b in bodies]
    space.iterations = max(iterations, usual)
    space.step(step)
    space.iterations = usual
    for body, state in zip(bodies, start, strict=True):
        body.position, body.velocity, body.angle, body.angular_velocity = state
