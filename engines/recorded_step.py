"""The records of single steps of a model from recorded states, and the protocol of what takes
them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from plumbob.analytic.reference import Array


@dataclass(frozen=True)
class StepInput:
    """The state before one or several steps, and what is held in them."""

    state: Array  # qpos, qvel and act, shape (n,)
    controls: Array  # a row for each step, shape (steps, controls)
    warm_start: Array  # acceleration with which the solver begins, shape (degrees of freedom,)


@dataclass(frozen=True)
class StepOutcome:
    """The state after steps."""

    state: Array  # qpos, qvel and act, shape (n,)
    warm_start: Array  # acceleration with which the solver of the next step begins
    # Contacts and limits that were active at the beginning of the first step
    touching: tuple[Any, ...]
    iterations: int = 0  # most iterations of the solver of any island in the last step


@dataclass(frozen=True)
class RecordedRun:
    """A run of steps, from its start to its end or to the last finite state."""

    states: Array  # qpos, qvel and act at the start and after each step, shape (n + 1, numbers)
    # Accelerations with which the solver begins, shape (n + 1, degrees of freedom)
    warm_starts: Array


@dataclass(frozen=True)
class Suspect:
    """A part of a model that may explain why a recorded step is not the model's."""

    name: str
    after: Callable[[StepInput, float], StepOutcome]
    """The outcome of steps with the numbers of the part multiplied by a factor."""


class RecordedSteps(Protocol):
    """Steps of a user's model, each from a given state. `MujocoRecordedSteps` documents the
    members."""

    @property
    def place_names(self) -> tuple[str, ...]: ...
    @property
    def units(self) -> tuple[str, ...]: ...
    @property
    def most_iterations(self) -> int: ...
    def run(self, before: StepInput) -> RecordedRun: ...
    def after(self, before: StepInput) -> StepOutcome: ...
    def converged(self, before: StepInput) -> StepOutcome: ...
    def nudged(
        self,
        before: StepInput,
        precision: type[np.floating[Any]],
        stored: Callable[[Array], Array],
        converged: bool = False,
    ) -> Array: ...
    def touching(self, state: Array) -> tuple[Any, ...]: ...
    def names_of(self, touching: tuple[Any, ...]) -> tuple[str, ...]: ...
    def without_contact(self, before: StepInput, pair: tuple[int, ...]) -> StepOutcome: ...
    def suspects(self) -> Iterator[Suspect]: ...
