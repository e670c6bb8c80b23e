"""Methods and engines: names, declared order, and the functions that run them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, Protocol, TypeVar

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.stability import Kind
from plumbob.engines.trajectory import Stepping as Stepping
from plumbob.engines.trajectory import Timed, Trajectory
from plumbob.models.registry import added_system, find_system
from plumbob.models.scene import Case, Scene

Ability = TypeVar("Ability")
ModelError = Mapping[str, Mapping[str, float]]
"""{observable: {reason: absolute bound}}: what a model itself adds, apart from the step."""
Options = Mapping[str, Any]  # an engine's own names of settings, and their values
USER_METHOD = "mujoco/mine"  # the method that a user's own file is read as


# [s] of a time step, whose inverse square contacts are as stiff as
SHORTEST, LONGEST = 1e-9, 1e3


def time_step(name: str, step: float, model: str = "") -> float:
    """Return a time step [s] that settings can be for, or that of a `model`, which the argument
    `name` gave; raises ParameterError where it is none."""
    if not SHORTEST <= step <= LONGEST:
        allowed = f"from {SHORTEST:g} to {LONGEST:g} s"
        if model:
            raise ParameterError(
                name, model, f"a model with a time step {allowed}, not {step:g}"
            )
        raise ParameterError(name, step, allowed)
    return step


class Unsupported(Exception):
    """A method that cannot run a scene; its text is the reason, one line."""


@dataclass(frozen=True)
class Method:
    """An engine with its integrator and, where it matters, model variant and contact profile."""

    name: str  # "mujoco/rk4", "mujoco/euler+coulomb"
    scheme: Scheme  # what it does in a step, for the theory of errors
    order: int | None  # of the global error in the step; None for adaptive methods
    # what its `step` argument means: [s], or rtol
    control: Literal["step", "tolerance"] = "step"
    settings: Options = field(default_factory=dict)  # the engine's own option names
    # of tolerances, loose to tight; steps are the scene's own
    step_sizes: tuple[float, ...] = ()
    systems: tuple[str, ...] = ()
    """Patterns of systems, or scenes, it is meant for beside its kinds, or after "!" is not."""
    kinds: tuple[str, ...] = ()
    """Kinds of system that it can do; with no names of systems either: all."""
    surrogate: str = ""
    """Why its model is not the full body, where it is not: what no robot model can take over."""

    def __getstate__(self) -> dict[str, Any]:
        """The fields as a plain dict: a read-only view of one cannot be sent to a worker."""
        return {**self.__dict__, "settings": dict(self.settings)}

    @property
    def engine(self) -> str:
        """Name of the engine, the part before the slash."""
        return self.name.partition("/")[0]


def meant(method: Method, scene: Scene) -> bool:
    """Whether `method` is meant for `scene`: by the kind of its system, or by its name or its
    system's. A system of another package is for the engines that it has builders for, and the
    methods that name it."""
    names = (scene.system, scene.name)
    unwanted = tuple(p[1:] for p in method.systems if p.startswith("!"))
    if any(fits(name, unwanted) for name in names):
        return False
    if any(fits(name, method.systems) for name in names):
        return True
    added = added_system(scene.system)
    if added is not None and method.engine not in added.builders:
        return False
    if not method.kinds:
        return len(unwanted) == len(method.systems)
    return (scene.kind or find_system(scene.system).kind) in method.kinds


class Simulation(Timed, Protocol):
    """A scene compiled for one method and step, ready to be run any number of times."""

    def run(self) -> Trajectory:
        """Run from the start to the end; the trajectory's `seconds` count the stepping alone."""


Limited = Literal[
    "not-converging",
    "off-prediction",
    "diverged",
    "pre-asymptotic",
    "unsupported",
    "converges",
]
_RENAMED = MappingProxyType({"pass": "predicted", "fail": "off-prediction"})
Patterns = str | tuple[str, ...]
"""Shell patterns of names, or after "!" of those that are left out."""


@lru_cache(maxsize=1 << 16)  # a page asks a million times
def fits(name: str, patterns: Patterns) -> bool:
    """Whether the name of a scene or a method is of one of these patterns, and none leaves it
    out."""
    several = (patterns,) if isinstance(patterns, str) else patterns
    unwanted = (pattern[1:] for pattern in several if pattern.startswith("!"))
    if any(fnmatchcase(name, pattern) for pattern in unwanted):
        return False
    return any(fnmatchcase(name, pattern) for pattern in several)


@dataclass(frozen=True)
class KnownLimit:
    """A verdict that is expected of an engine's methods on scenes, in place of `predicted`."""

    scenes: Patterns
    methods: Patterns
    verdict: Limited
    reason: str
    size: float = 0.0
    """Relative error, known within a factor of two: the median over the finest five runs of the
    quick profile; of no meaning where the verdict is `unsupported` or `converges`."""
    other: Limited | Literal["predicted"] | None = None
    """A verdict that is also expected: which depends on the step sizes."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "verdict", present(self.verdict))
        object.__setattr__(self, "other", self.other and present(self.other))


def present(verdict: str) -> str:
    """A verdict by its present name; earlier ones are understood."""
    return _RENAMED.get(verdict, verdict) if isinstance(verdict, str) else verdict


@dataclass(frozen=True)
class KnownStepLimit:
    """A largest step that is known to differ from its prediction."""

    scenes: Patterns
    methods: Patterns
    ratio: float  # measured over predicted
    reason: str
    kind: Kind = "unstable"


@dataclass(frozen=True)
class KnownGradientLimit:
    """A derivative whose error is known to differ from its prediction."""

    scenes: Patterns
    methods: Patterns
    by: Patterns  # parameters
    size: float  # of the relative error,
    factor: float  # known within it
    reason: str
    ways: Patterns = "*"


@dataclass(frozen=True)
class NotRead:
    """Observables that an engine does not give of scenes with methods of these patterns."""

    scenes: Patterns
    methods: Patterns
    observables: tuple[str, ...]
    reason: str


@dataclass(frozen=True)
class Engine:
    """A translation of scenes into one engine's terms; the package is imported when it runs."""

    name: str
    package: str  # the import name that must be there
    methods: tuple[Method, ...]
    prepare: Callable[[Case, Method, float], Simulation]  # raises Unsupported
    model_error: Callable[[Case, Method, float], ModelError]
    optional: bool = False  # a peer: not missed unless it is asked for by name
    not_read: Mapping[str, str] = field(default_factory=dict)
    """{observable: why}: what an engine of another package gives of no scene."""
    distribution: str = ""  # the package that adds it, where that is not plumbob
    limits: Path | None = None
    """The file that declares the limits of an engine of another package, as those of `limits` do
    for ours."""
    known_limits: tuple[KnownLimit, ...] = ()  # and those declared in Python
    abilities: tuple[object, ...] = ()  # what else it can do: records of `engines.abilities`

    def ability(self, kind: type[Ability]) -> Ability | None:
        """The engine's ability of a kind; None where it has none."""
        return next(iter(self.abilities_of(kind)), None)

    def abilities_of(self, kind: type[Ability]) -> list[Ability]:
        """All the engine's abilities of a kind."""
        return [ability for ability in self.abilities if isinstance(ability, kind)]
