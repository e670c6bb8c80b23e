"""What a builder makes of a scene in pymunk's terms, and how the builder of a system is found."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, cast

import pymunk

from plumbob.engines.adapters.builders import find_builder
from plumbob.engines.method import Method
from plumbob.models.scene import System


@dataclass(frozen=True)
class Translation:
    """A scene as a space at its start, what to do before each step, and what to read off it."""

    space: pymunk.Space
    read: Callable[[], Mapping[str, float]]  # the observables, and any channels, of this moment
    act: Callable[[float], None] | None = None
    """Called with the time [s] before each step: forces hold for one step."""
    channels: frozenset[str] = frozenset()  # names that `read` gives beside the observables
    limits: Mapping[str, float] = field(default_factory=dict)
    """Magnitudes of observables that only a diverged run exceeds."""
    following: Callable[[], Mapping[str, float]] | None = None
    """Observables that belong to the step which begins at a sample: read when it is done."""


class Builder(Protocol):
    """What the module of a family of systems, `adapters/pymunk/<family>.py`, offers."""

    def build(self, problem: Any, method: Method, step: float) -> Translation:
        """Translate `problem` for `method` at `step` [s]; raises Unsupported."""
        ...

    def model_error(
        self, problem: Any, duration: float, method: Method, step: float
    ) -> Mapping[str, Mapping[str, float]]:
        """Bounds on what the model adds to each observable over `duration` [s], by reason."""
        ...


def builder(system: System) -> Builder:
    """The builder of `system`; raises Unsupported when there is none."""
    return cast(Builder, find_builder("pymunk", system))
