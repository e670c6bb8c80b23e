"""What a method and an engine are: names, declared order, and the functions that run them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from typing import Any, Literal, Protocol

from plumbob.analytic.errors.schemes import Scheme
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Case, Scene


class Unsupported(Exception):
    """A method that cannot run a scene; its text is the reason, one line."""


@dataclass(frozen=True)
class Method:
    """An engine with its integrator and, where it matters, model variant and contact profile."""

    name: str  # "mujoco/rk4", "mujoco/euler+coulomb"
    scheme: Scheme  # what it does in a step, for the theory of errors
    order: int | None  # of the global error in the step; None for adaptive methods
    control: Literal["step", "tolerance"] = "step"  # what its `step` argument means: [s], or rtol
    settings: Mapping[str, Any] = field(default_factory=dict)  # the engine's own option names
    step_sizes: tuple[float, ...] = ()  # of tolerances, loose to tight; steps are the scene's own
    systems: tuple[str, ...] = ()  # patterns of systems, or scenes, it is meant for; empty: all

    def __getstate__(self) -> dict[str, Any]:
        """What a worker is sent: a read-only view of a dict cannot be."""
        return {**self.__dict__, "settings": dict(self.settings)}

    @property
    def engine(self) -> str:
        """Name of the engine, the part before the slash."""
        return self.name.partition("/")[0]


def meant(method: Method, scene: Scene) -> bool:
    """Whether `method` is meant for `scene`, by its name or its system's."""
    names = (scene.system, scene.name)
    return not method.systems or any(fnmatchcase(n, p) for p in method.systems for n in names)


class Simulation(Protocol):
    """A scene compiled for one method and step, ready to be run any number of times."""

    compile_seconds: float

    def run(self) -> Trajectory:
        """Run from the start to the end; the trajectory's `seconds` count the stepping alone."""
        ...


@dataclass(frozen=True)
class Engine:
    """A translation of scenes into one engine's terms; the package is imported when it runs."""

    name: str
    package: str  # the import name that must be there
    methods: tuple[Method, ...]
    prepare: Callable[[Case, Method, float], Simulation]  # raises Unsupported
    model_error: Callable[[Case, Method, float], Mapping[str, Mapping[str, float]]]
    """{observable: {reason: absolute bound}}: what the model itself adds, apart from the step."""
    optional: bool = False  # a peer: not missed unless it is asked for by name
