"""A scene built for one pymunk method and step, and its runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import pymunk

from plumbob.engines.adapters.stepping import (
    Built,
    Observed,
    SteppedSimulation,
    by_name,
    stepped,
)
from plumbob.engines.method import Method
from plumbob.engines.registry import find_builder
from plumbob.engines.trajectory import ByName
from plumbob.models.scene import Case


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
    before_sample: Callable[[float], None] | None = None
    """Called with the time [s] before the step that ends at a sample."""


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


def prepared(case: Case, method: Method, step: float) -> SteppedSimulation:
    """Build `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    build = find_builder("pymunk", case.system).build
    return stepped(case, step, lambda: _built(build(case.problem, method, step), step))


def _built(scene: Translation, step: float) -> Built:
    move = scene.space.step
    act = scene.act
    following = scene.following
    before = scene.before_sample
    sample: dict[str, float] = {}  # the latest
    taken = 0

    def take(first: int, last: int) -> None:
        if act is None:
            for _ in range(first, last):
                move(step)
        else:
            for n in range(first, last):
                act(n * step)
                move(step)

    def advance(first: int, last: int) -> None:
        nonlocal taken
        taken, middle = last, first
        if following is not None:
            follow(first)
            middle = first + 1
        elif before is not None:
            middle = last - 1
            take(first, middle)
            before(middle * step)
        take(middle, last)

    def follow(first: int) -> None:
        take(first, first + 1)
        assert following is not None
        sample.update(following())

    def read() -> ByName:
        nonlocal sample
        sample = {**scene.read()}
        return sample

    def gather(rows: Sequence[ByName]) -> Observed:
        if following is not None:
            follow(taken)
        return by_name(rows)

    return Built(advance, read, scene.limits, gather)
