"""A scene as a space of pymunk, and what its builders share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import pymunk

from plumbob.engines.trajectory import ByName


@dataclass(frozen=True)
class Translation:
    """A scene as a space at its start, what to do before each step, and what to read off it."""

    space: pymunk.Space
    read: Callable[[], ByName]  # the observables of this moment
    act: Callable[[float], None] | None = None
    """Called with the time [s] before each step: forces last for one step."""
    limits: ByName = field(default_factory=dict)
    """Magnitudes of observables that only a diverged run exceeds."""
    following: Callable[[], ByName] | None = None
    """Observables of the step that begins at a sample: read when it is done."""


def vector(value: complex) -> tuple[float, float]:
    """A plane vector as pymunk takes it."""
    return value.real, value.imag


def touching(
    space: pymunk.Space, body: pymunk.Body, shapes: Sequence[pymunk.Shape], **surface: float
) -> None:
    """Add a body with its shapes to a space, in contact with each other: of what a `surface` is
    like, such as its friction, engines take the product, and one side has 1."""
    ground, *others = shapes
    for name, value in surface.items():
        setattr(ground, name, 1.0)
        for shape in others:
            setattr(shape, name, value)
    space.add(body, *shapes)


def settle(space: pymunk.Space, step: float, iterations: int) -> None:
    """Let the solver find the impulses of joints and contacts at the start, in a step that is
    undone: it begins with those of a step before."""
    usual = space.iterations
    bodies = space.bodies
    start = [(b.position, b.velocity, b.angle, b.angular_velocity) for b in bodies]
    space.iterations = max(iterations, usual)
    space.step(step)
    space.iterations = usual
    for body, state in zip(bodies, start, strict=True):
        body.position, body.velocity, body.angle, body.angular_velocity = state
