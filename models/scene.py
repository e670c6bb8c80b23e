"""What a scene and a system are: data, and the functions that give the data its meaning."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from plumbob.analytic.errors.theory import ErrorTheory, no_theory
from plumbob.analytic.reference import Array, Reference

Parameters = Mapping[str, Any]


@dataclass(frozen=True)
class Observable:
    """A quantity that is compared: its name and its SI unit."""

    name: str
    unit: str


@dataclass(frozen=True)
class Scene:
    """A system with its parameters, its start, how long it runs and where it comes from."""

    name: str  # "system/case"
    summary: str
    parameters: Parameters  # SI units, radians; the start included; the names of `--set`
    duration: float  # [s]
    steps: tuple[float, ...]  # step_sizes of fixed steps [s], coarse to fine
    source: str
    profile: Literal["quick", "full"] = "full"  # the smallest profile that runs it
    hard: str = ""  # what makes it hard, where it is there for that

    def __getstate__(self) -> dict[str, Any]:
        """What a worker is sent: a read-only view of a dict cannot be."""
        return {**self.__dict__, "parameters": dict(self.parameters)}

    @property
    def system(self) -> str:
        """Name of the system, the part before the slash."""
        return self.name.partition("/")[0]


def replaced(parameters: Parameters, changes: Parameters) -> Parameters:
    """Parameters with some values changed."""
    return {**parameters, **changes}


@dataclass(frozen=True)
class System:
    """A mechanical system: what it observes, its scenes, and its exact answer."""

    name: str
    title: str
    observables: tuple[Observable, ...]  # the first is the one that orders and verdicts lead with
    parameters: tuple[str, ...]  # every name that `--set` takes
    scenes: tuple[Scene, ...]
    default: str  # the case meant by the system's name alone
    problem: Callable[[Parameters], Any]  # parameters -> analytic object; ParameterError
    reference: Callable[[Any], Reference]  # problem -> its exact motion
    invariants: Callable[[Any, Mapping[str, Array]], Mapping[str, Array]]  # relative drifts
    facts: Callable[[Any], Mapping[str, Any]]  # what `solve` says beside the observables
    mjcf: Path  # the model on its own
    family: str  # by which an engine's adapter finds its builder: adapters/<engine>/<family>.py
    change: Callable[[Parameters, Parameters], Parameters] = replaced
    errors: Callable[[Any], ErrorTheory] = no_theory  # what fixed steps do to the exact motion
    weight: float = 1.0  # what a step of it costs, roughly, in steps of a pendulum

    def case(self, scene: Scene) -> Case:
        """The problem and the exact motion of `scene`, worked out; raises ParameterError."""
        problem = self.problem(scene.parameters)
        return Case(self, scene, problem, self.reference(problem), self.errors(problem))


@dataclass(frozen=True)
class Case:
    """A scene with what follows from its parameters, worked out once for all its runs."""

    system: System
    scene: Scene
    problem: Any  # the system's analytic object
    reference: Reference  # its exact motion
    errors: ErrorTheory  # what fixed steps do to that

    def lasting(self, duration: float) -> Case:
        """The same case for another `duration` [s]."""
        return replace(self, scene=replace(self.scene, duration=duration))
