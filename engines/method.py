"""Methods and engines: their names, declared orders and limits, and the functions that run them."""

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
from plumbob.analytic.stability import FailureKind
from plumbob.engines.trajectory import Stepping as Stepping
from plumbob.engines.trajectory import TimedSimulation, Trajectory
from plumbob.models.registry import added_system, find_system
from plumbob.models.scene import Case, Scene

Ability = TypeVar("Ability")
ModelError = Mapping[str, Mapping[str, float]]
"""{observable: {reason: absolute bound}}: errors of an engine's model that no step reduces."""
Options = Mapping[str, Any]  # an engine's own names of settings, and their values
USER_METHOD = "mujoco/mine"  # name of the method that is read from a user's model file
# Scenes for models of the capsule on a line alone, which need not run every heading of a line.
# They stand here since a stored study is judged without loading the capsule's exact motions.
ONE_LINE = (
    *("capsule-line/[!h]*", "capsule-line/heavy-slider", "capsule-hold", "capsule-train"),
    "capsule-coast/translation",
)

# [s] allowed time steps: the stiffness of contacts is proportional to the step to the power of -2
SHORTEST_TIME_STEP, LONGEST_TIME_STEP = 1e-9, 1e3


def time_step(name: str, step: float, model: str = "") -> float:
    """Returns a time step [s] if settings can be made for it. Raises ParameterError otherwise, with
    the `name` of the argument; the step is the argument itself, or the step of a `model` file that
    the argument names."""
    if not SHORTEST_TIME_STEP <= step <= LONGEST_TIME_STEP:
        allowed = f"from {SHORTEST_TIME_STEP:g} to {LONGEST_TIME_STEP:g} s"
        if model:
            raise ParameterError(
                name, model, f"a model with a time step {allowed}, not {step:g}"
            )
        raise ParameterError(name, step, allowed)
    return step


class Unsupported(Exception):
    """Raised if a method cannot run a scene; the text is the reason, in one line."""


def no_error(*arguments: object) -> ModelError:
    """An empty mapping: the engine's model is the system itself, whatever the arguments."""
    return {}


@dataclass(frozen=True)
class Method:
    """An engine with its integrator and, if it has any, its variant of the model and its
    contacts."""

    name: str  # "mujoco/rk4", "mujoco/euler+coulomb"
    scheme: Scheme  # its time-stepping rule, for the theory of errors
    order: int | None  # order of the global error in the step; None for adaptive methods
    # meaning of its `step` argument: time step [s], or relative tolerance
    control: Literal["step", "tolerance"] = "step"
    settings: Options = field(default_factory=dict)  # the engine's own option names
    # tolerances of an adaptive method, loose to tight; time steps are those of the scene
    step_sizes: tuple[float, ...] = ()
    systems: tuple[str, ...] = ()
    """Patterns of systems or scenes that it runs beside its kinds; after "!" those that it does not
    run."""
    kinds: tuple[str, ...] = ()
    """Kinds of system that it runs. If both `kinds` and `systems` are empty, it runs all
    systems."""
    surrogate: str = ""
    """Why its model is a simplification that no robot model can take over; empty if its model is
    the full body."""

    def __getstate__(self) -> dict[str, Any]:
        """The fields as a plain dict: a read-only view of one cannot be sent to a worker."""
        return {**self.__dict__, "settings": dict(self.settings)}

    @property
    def engine(self) -> str:
        """Name of the engine, the part before the slash."""
        return self.name.partition("/")[0]


def meant(method: Method, scene: Scene) -> bool:
    """Whether `method` is meant for `scene`: the method names the scene, its system, or the kind of
    its system. A system of another package is also meant for the engines for which the package has
    builders, and otherwise only for methods that name it."""
    names = (scene.system, scene.name)
    unwanted = tuple(pattern[1:] for pattern in method.systems if pattern.startswith("!"))
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


class Simulation(TimedSimulation, Protocol):
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
"""Shell patterns of names; a pattern after "!" leaves names out."""


@lru_cache(maxsize=1 << 16)  # one page calls it a million times
def fits(name: str, patterns: Patterns) -> bool:
    """Whether the name of a scene or a method matches one of these patterns, and no pattern leaves
    it out."""
    listed = (patterns,) if isinstance(patterns, str) else patterns
    unwanted = (pattern[1:] for pattern in listed if pattern.startswith("!"))
    if any(fnmatchcase(name, pattern) for pattern in unwanted):
        return False
    return any(fnmatchcase(name, pattern) for pattern in listed)


@dataclass(frozen=True)
class KnownLimit:
    """A verdict that is expected of an engine's methods on scenes, in place of `predicted`."""

    scenes: Patterns
    methods: Patterns
    verdict: Limited
    reason: str
    size: float = 0.0
    """Relative error, known within a factor of two: the median over the five finest runs of the
    quick profile. It has no meaning if the verdict is `unsupported` or `converges`."""
    other: Limited | Literal["predicted"] | None = None
    """A second verdict that is expected too: the step sizes decide which of the two it is."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "verdict", present(self.verdict))
        object.__setattr__(self, "other", self.other and present(self.other))


def present(verdict: str) -> str:
    """The present name of a verdict, given the present or an earlier name."""
    return _RENAMED.get(verdict, verdict) if isinstance(verdict, str) else verdict


@dataclass(frozen=True)
class KnownStepLimit:
    """A largest step that is known to differ from its prediction."""

    scenes: Patterns
    methods: Patterns
    ratio: float  # ratio of the measured step to the predicted step
    reason: str
    kind: FailureKind = "unstable"


@dataclass(frozen=True)
class KnownGradientLimit:
    """A derivative whose error is known to differ from its prediction."""

    scenes: Patterns
    methods: Patterns
    by: Patterns  # names of the parameters by which the derivative is taken
    size: float  # relative error of the derivative
    factor: float  # factor within which the size is known
    reason: str
    ways: Patterns = "*"


@dataclass(frozen=True)
class NotRepeatable:
    """Scenes on which methods of an engine do not repeat their bits in another process, or in
    another order of runs."""

    scenes: Patterns
    methods: Patterns
    reason: str


@dataclass(frozen=True)
class NotRead:
    """Observables that an engine does not give for these scenes with these methods."""

    scenes: Patterns
    methods: Patterns
    observables: tuple[str, ...]
    reason: str


@dataclass(frozen=True)
class Engine:
    """A translation of scenes into one engine's terms; the package is imported when it runs."""

    name: str
    package: str  # import name of the engine's package
    methods: tuple[Method, ...]
    prepare: Callable[[Case, Method, float], Simulation]  # raises Unsupported
    model_error: Callable[[Case, Method, float], ModelError]
    # If true, its runs are left out without its package, unless the user names the engine.
    optional: bool = False
    not_read: Mapping[str, str] = field(default_factory=dict)
    """{observable: reason}: observables that the engine gives for no scene. Only an engine that
    another package adds declares them here."""
    distribution: str = ""  # name of the package that adds the engine; empty for plumbob's
    limits: Path | None = None
    """File of limits of an engine of another package; plumbob's engines have theirs in
    `limits/`."""
    known_limits: tuple[KnownLimit, ...] = ()  # limits that are declared in Python
    abilities: tuple[object, ...] = ()  # records of `engines.abilities`

    def ability(self, kind: type[Ability]) -> Ability | None:
        """The engine's first ability of this kind; None if it lacks the ability."""
        return next(iter(self.abilities_of(kind)), None)

    def abilities_of(self, kind: type[Ability]) -> list[Ability]:
        """All abilities of the engine of this kind."""
        return [ability for ability in self.abilities if isinstance(ability, kind)]
