"""Scenes and systems: data, and the functions that give the data its meaning."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from plumbob.analytic.reference import Array, Reference, Signals
from plumbob.analytic.stability import StabilityTheory
from plumbob.analytic.theory import ErrorTheory, no_theory

if TYPE_CHECKING:
    from plumbob.analytic.sensitivities.neighbours import Neighbours, Sensitivity
    from plumbob.models.model_file import ModelFile

Parameters = Mapping[str, Any]
Answers = Callable[[Any, Array], Mapping["Observable", Array]]
Gradients = Callable[[Sequence["Neighbours[Any]"], Array], list["Sensitivity"]]
# Kinds of system, by which a method says what it can do; a new kind is another string.
ONE_SMOOTH: Final = "one smooth degree of freedom"
SMOOTH: Final = "smooth degrees of freedom"
FREE_ROTATION: Final = "free rotation"
ON_SUPPORTS: Final = "body on supports"
ON_PLANE: Final = "ball or box above a plane"


@dataclass(frozen=True)
class Observable:
    """A quantity that is compared: its name and its SI unit."""

    name: str
    unit: str

    @property
    def force(self) -> bool:
        """Whether it is a force, which is read off a step; all others start with the scene's
        values."""
        return self.unit.startswith("N")


@dataclass(frozen=True)
class Quantity:
    """An observable that a scene is about, and the characteristic size that its error is compared
    with, so that errors of different scenes and observables can be compared."""

    observable: str
    scale: float  # in the observable's unit
    when: Literal["run", "end"] = "run"  # the largest error over the run, or the one at its end


@dataclass(frozen=True)
class Scene:
    """A system with its parameters, its start, how long it runs and where it comes from."""

    name: str  # "system/case"
    summary: str
    parameters: Parameters  # SI units, radians; the start included; the names of `--set`
    duration: float  # [s]
    steps: tuple[float, ...]  # step sizes [s] of fixed-step methods, from large to small
    source: str
    profile: Literal["quick", "full"] = "full"  # the smallest profile that runs it
    hard: str = ""  # why it is hard, for a hard scene
    kind: str = ""  # of its system, set by the registry, so that asking for it loads no system

    def __getstate__(self) -> dict[str, Any]:
        """State without the read-only view of a dict, which cannot be pickled."""
        return {**self.__dict__, "parameters": dict(self.parameters)}

    @property
    def system(self) -> str:
        """Name of the system, the part before the slash."""
        return self.name.partition("/")[0]


def later(function: str) -> Callable[..., Any]:
    """A function by its dotted name, whose module is imported when it is called."""
    return partial(_loaded, *function.rsplit(".", 1))


def from_analytic(path: str) -> Callable[..., Any]:
    """The function MODULE.NAME below `plumbob.analytic`, which asking for a scene does not load."""
    return later(f"plumbob.analytic.{path}")


def _loaded(module: str, name: str, *arguments: Any) -> Any:
    return getattr(import_module(module), name)(*arguments)


def replaced(parameters: Parameters, changes: Parameters) -> Parameters:
    """Parameters with some values changed."""
    return {**parameters, **changes}


def scene_of(
    case: str,
    summary: str,
    duration: float,
    profile: Any = "full",
    hard: str = "",
    *,
    system: str,
    steps: tuple[float, ...],
    base: Parameters,
    source: str,
    change: Callable[[Parameters, Parameters], Parameters] = replaced,
    **values: Any,
) -> Scene:
    """A scene with `values` in place of some of the parameters of `base`."""
    parameters = change(base, values)
    return Scene(
        f"{system}/{case}", summary, parameters, duration, steps, source, profile, hard
    )


def step_sizes(coarse: float, fine: float) -> tuple[float, ...]:
    """Steps [s] 1, 2 and 5 times powers of ten, from `coarse` down to `fine`, both included."""
    decades = range(math.ceil(math.log10(coarse)), math.floor(math.log10(fine)) - 1, -1)
    # Through decimal text: 5e-4 is the double nearest to 0.0005, 5 * 10**-4 need not be.
    round_numbers = [
        float(f"{digit}e{exponent}") for exponent in decades for digit in (5, 2, 1)
    ]
    return tuple(h for h in round_numbers if fine * (1 - 1e-9) <= h <= coarse * (1 + 1e-9))


@dataclass(frozen=True)
class System:
    """A mechanical system: what it observes, its scenes, and its exact answer."""

    name: str
    title: str
    observables: tuple[Observable, ...]  # orders and verdicts lead with the first
    parameters: tuple[str, ...]  # every name that `--set` takes
    scenes: tuple[Scene, ...]
    default: str  # the case meant by the system's name alone
    problem: Callable[[Parameters], Any]  # parameters -> analytic object; ParameterError
    reference: Callable[[Any], Reference]  # problem -> its exact motion
    invariants: Callable[[Any, Signals], Signals]  # relative drifts
    facts: Callable[[Any], Mapping[str, Any]]  # what `solve` reports beside the observables
    mjcf: Path  # the model on its own
    family: str  # by which an engine's adapter finds its builder: adapters/<engine>/<family>.py
    kind: str = ""  # by which methods claim it: without one those alone that name it
    change: Callable[[Parameters, Parameters], Parameters] = replaced
    errors: Callable[[Any], ErrorTheory] = no_theory  # theory of fixed steps' errors
    # theory of the largest step
    stability: Callable[[Any], StabilityTheory | None] | None = None
    start: tuple[str, ...] = ()
    """Parameters of the start of the motion; where a scene has none of them, the last is zero."""

    weight: float = 1.0  # rough cost of a step, in steps of a pendulum
    interest: Callable[[Case], tuple[Quantity, ...]] | None = None
    """The quantities of interest of a case; None: the first observable, over the whole run."""

    sensitivity: Gradients | None = None
    """Derivatives of the observables by parameters, of neighbours of a problem at times [s], shape
    (n,); None: differences of the exact motion."""
    left_out: Parameters = field(default_factory=dict)
    """Values of parameters that a scene may leave out, where these are not 0."""
    structure: Callable[[Any], Any] = lambda problem: None
    """The parts of a problem that cannot change smoothly with a parameter."""
    alike: Callable[[Any, Any], bool] = lambda problem, near: True
    """Whether `sensitivity` may take differences between a problem and one near it."""
    also: Answers = lambda problem, places: {}
    """Exact answers beside the observables, of a problem at times [s], shape (n,)."""
    by_angle: Answers | None = None
    """Exact answers of a problem with the angle [rad], shape (n,), as the parameter."""
    builders: Mapping[str, str] = field(default_factory=dict)
    """{engine: the module that builds it there}, where the family does not name it."""
    model_module: str = ""
    """The module whose `MODEL`, a ModelFile, says how a problem stands in the file `mjcf`, imported
    when an engine asks for it; empty: no engine makes a mechanism of the file."""
    distribution: str = ""  # the package that adds it, where that is not plumbob

    @property
    def model_file(self) -> ModelFile | None:
        """How a problem stands in the file `mjcf`; None: no engine makes a mechanism of it."""
        if not self.model_module:
            return None
        found: ModelFile = import_module(self.model_module).MODEL
        return found

    def quantities(self, case: Case) -> tuple[Quantity, ...]:
        """The quantities that a case of this system is about, with scales."""
        if self.interest is not None:
            return self.interest(case)
        first = self.observables[0].name
        times = np.linspace(0.0, case.scene.duration, 101)
        largest = float(np.abs(case.reference.observe(times)[first]).max())
        return (Quantity(first, largest or 1.0),)

    def case(self, scene: Scene) -> Case:
        """The problem and the exact motion of `scene`; raises ParameterError."""
        problem = self.problem(scene.parameters)
        return Case(self, scene, problem, self.reference(problem), self.errors(problem))


@dataclass(frozen=True)
class Case:
    """A scene with its problem and exact motion, computed once for all its runs.

    >>> import numpy as np
    >>> from plumbob.models.registry import case_of, scene
    >>> case = case_of(scene("cone-pendulum/rotating-base"))
    >>> exact = case.reference.observe(np.array([0.1, 0.5]))
    >>> [round(float(theta), 6) for theta in exact["theta"]]
    [4.073905, 19.655093]
    """

    system: System
    scene: Scene
    problem: Any  # the system's analytic object
    reference: Reference  # its exact motion
    errors: ErrorTheory  # theory of fixed steps' errors
    # of a run, at most: enough for a smooth curve; errors are judged at them
    samples: int = 500

    def lasting(self, duration: float, samples: int = 500) -> Case:
        """The same case for another `duration` [s], with at most so many `samples`, which MuJoCo,
        pymunk and scipy heed, and engines that are stepped alike."""
        return replace(self, scene=replace(self.scene, duration=duration), samples=samples)
