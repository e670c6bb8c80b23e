"""A scene as a space of pymunk, and functions that builders share."""

from __future__ import annotations

from collections.abc import Callable
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


def settle(space: pymunk.Space, step: float, iterations: int) -> None:
    """Lets the solver find the impulses of joints and contacts at the start, in a step that is
    undone. The next step begins with these impulses."""
    usual_iterations = space.iterations
    bodies = space.bodies
    states = [
        (body.position, body.velocity, body.angle, body.angular_velocity) for body in bodies
    ]
    space.iterations = max(iterations, usual_iterations)
    space.step(step)
    space.iterations = usual_iterations
    for body, state in zip(bodies, states, strict=True):
        body.position, body.velocity, body.angle, body.angular_velocity = state
