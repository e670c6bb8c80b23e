"""Scenes, systems and cases: data, and the functions that give the data its meaning."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from plumbob.analytic.reference import Array, Reference, Signals
from plumbob.analytic.stability import StabilityTheory
from plumbob.analytic.theory import ErrorTheory, no_theory

if TYPE_CHECKING:
    from plumbob.analytic.sensitivities.neighbours import Neighbours, Sensitivity
    from plumbob.analytic.stability import LoopQuantity
    from plumbob.analytic.systems.held_loop import HeldLoop
    from plumbob.models.model_file import ModelFile

Parameters = Mapping[str, Any]
Answers = Callable[[Any, Array], Mapping["Observable", Array]]
ExactGradients = Callable[[Sequence["Neighbours[Any]"], Array], list["Sensitivity"]]
# Kinds of systems. A method names the kinds that it can run; a new kind is another string.
ONE_SMOOTH: Final = "one smooth degree of freedom"
SMOOTH: Final = "smooth degrees of freedom"
FREE_ROTATION: Final = "free rotation"
ON_SUPPORTS: Final = "body on supports"
ON_PLANE: Final = "ball or box above a plane"
UNRANKED: Final = 100  # rank on the pages of a system that does not declare one


@dataclass(frozen=True)
class Observable:
    """A quantity that runs are compared by: its name and its SI unit."""

    name: str
    unit: str

    @property
    def force(self) -> bool:
        """Whether the observable is a force. A force is read off a step; every other observable
        starts with the scene's value."""
        return self.unit.startswith("N")


@dataclass(frozen=True)
class Quantity:
    """A quantity of interest: an observable with a characteristic size. The error is compared with
    this size, so that errors of different scenes and observables are comparable."""

    observable: str
    scale: float  # in the observable's unit
    when: Literal["run", "end"] = "run"  # "run": largest error over the run; "end": at its end


@dataclass(frozen=True)
class Scene:
    """A system with its parameters, its start, its duration, its step sizes and its source."""

    name: str  # "system/case"
    summary: str
    parameters: Parameters  # by the names of `--set`, the start included; SI units, radians
    duration: float  # [s]
    steps: tuple[float, ...]  # step sizes [s] of fixed-step methods, from large to small
    source: str
    profile: Literal["quick", "full"] = "full"  # the smallest profile that runs the scene
    hard: str = ""  # reason why the scene is hard; empty if it is not
    kind: str = ""  # kind of the system, set by the registry: asking for it loads no system

    def __getstate__(self) -> dict[str, Any]:
        """Returns the state to pickle: a read-only view of a dict cannot be pickled."""
        return {**self.__dict__, "parameters": dict(self.parameters)}

    @property
    def system(self) -> str:
        """Name of the system: the part of the scene's name before the slash."""
        return self.name.partition("/")[0]


def replaced(parameters: Parameters, changes: Parameters) -> Parameters:
    """Returns parameters with some values changed."""
    return {**parameters, **changes}


def make_scene(
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
    """Returns a scene of a system. `values` replace some of the parameters of `base`, by the
    function `change`; `duration` and `steps` are in [s]."""
    return Scene(
        name=f"{system}/{case}",
        summary=summary,
        parameters=change(base, values),
        duration=duration,
        steps=steps,
        source=source,
        profile=profile,
        hard=hard,
    )


def step_sizes(coarse: float, fine: float) -> tuple[float, ...]:
    """Returns step sizes [s], 1, 2 and 5 times powers of ten, from `coarse` down to `fine`, both
    included."""
    largest_exponent = math.ceil(math.log10(coarse))
    smallest_exponent = math.floor(math.log10(fine))
    round_numbers: list[float] = []
    for exponent in range(largest_exponent, smallest_exponent - 1, -1):
        # Decimal text gives the nearest double: 5e-4 is nearest to 0.0005, 5 * 10**-4 need not be.
        round_numbers += [float(f"{digit}e{exponent}") for digit in (5, 2, 1)]
    smallest = fine * (1 - 1e-9)
    largest = coarse * (1 + 1e-9)
    return tuple(step for step in round_numbers if smallest <= step <= largest)


@dataclass(frozen=True)
class System:
    """A mechanical system: its observables, its scenes, its exact answer, and the theory of its
    errors."""

    name: str
    title: str
    observables: tuple[Observable, ...]  # the first is the leading one in orders and verdicts
    parameters: tuple[str, ...]  # every name that `--set` takes
    scenes: tuple[Scene, ...]
    default: str  # name of the case that the system's name alone means
    problem: Callable[[Parameters], Any]  # returns the analytic object; raises ParameterError
    reference: Callable[[Any], Reference]  # returns the exact motion of a problem
    invariants: Callable[[Any, Signals], Signals]  # returns relative drifts
    facts: Callable[[Any], Mapping[str, Any]]  # numbers that `solve` reports, with their names
    mjcf: Path  # model file without a scene around it
    family: str  # name of the builder in an engine's adapter: adapters/<engine>/<family>.py
    kind: str = ""  # kind that methods name; empty: only methods that name the system run it
    change: Callable[[Parameters, Parameters], Parameters] = replaced
    errors: Callable[[Any], ErrorTheory] = no_theory  # returns theory of fixed steps' errors
    # Returns the theory of the largest step of a problem; None without such a theory.
    stability: Callable[[Any], StabilityTheory | None] | None = None
    # Returns the loop of a problem whose controls are fed back; None if they are not.
    loop: Callable[[Any], HeldLoop | None] = lambda problem: None
    # Returns the parameters that change the hold [s], the delay [s] or both gains of that loop.
    loop_changes: Callable[[Any, LoopQuantity, float], Parameters] = (
        lambda problem, quantity, value: {}
    )
    start: tuple[str, ...] = ()
    """Names of the parameters of the start. If a scene has none of them, the last one is zero."""

    rank: int = UNRANKED  # place among the systems on the pages; equal ranks follow by name
    phenomenon: int = 0  # row in the table of canonical phenomena, from 1; 0: in no row
    weight: float = 1.0  # rough cost of a step, in steps of a pendulum
    interest: Callable[[Case], tuple[Quantity, ...]] | None = None
    """Returns the quantities of interest of a case; None: the first observable, over the run."""

    sensitivity: ExactGradients | None = None
    """Returns derivatives of the observables with respect to parameters, from neighbours of a
    problem, at times [s], shape (n,); None: differences of the exact motion are used."""
    left_out: Parameters = field(default_factory=dict)
    """Values, other than 0, of parameters that a scene may leave out."""
    structure: Callable[[Any], Any] = lambda problem: None
    """Returns the parts of a problem that cannot change smoothly with a parameter."""
    alike: Callable[[Any, Any], bool] = lambda problem, near: True
    """Whether `sensitivity` may take differences between a problem and a problem near it."""
    also: Answers = lambda problem, places: {}
    """Returns further exact answers to a problem, at times [s], shape (n,)."""
    by_angle: Answers | None = None
    """Returns exact answers to a problem as functions of the angle [rad], shape (n,)."""
    builders: Mapping[str, str] = field(default_factory=dict)
    """{engine: module that builds the system there}, if `family` does not name the module."""
    model_module: str = ""
    """Name of the module whose `MODEL`, a ModelFile, relates a problem to the file `mjcf`. It is
    imported when an engine asks for it. Empty: no engine makes a mechanism of the file."""
    distribution: str = ""  # name of the package that adds the system; empty: plumbob itself

    @property
    def model_file(self) -> ModelFile | None:
        """The functions that relate a problem to the file `mjcf`; None if engines do not build the
        system from a file."""
        if not self.model_module:
            return None
        model_file: ModelFile = import_module(self.model_module).MODEL
        return model_file

    def quantities(self, case: Case) -> tuple[Quantity, ...]:
        """Returns the quantities of interest of a case of this system, with their scales."""
        if self.interest is not None:
            return self.interest(case)
        first = self.observables[0].name
        times = np.linspace(0.0, case.scene.duration, 101)
        largest = float(np.abs(case.reference.observe(times)[first]).max())
        return (Quantity(first, largest or 1.0),)

    def case(self, scene: Scene) -> Case:
        """Returns the case of `scene`: its problem and its exact motion; raises ParameterError."""
        problem = self.problem(scene.parameters)
        return Case(self, scene, problem, self.reference(problem), self.errors(problem))


@dataclass(frozen=True)
class Case:
    """A scene with its problem and its exact motion, computed once for all its runs.

    >>> import numpy as np
    >>> from plumbob.models.registry import case_of, scene
    >>> case = case_of(scene("cone-pendulum/rotating-base"))
    >>> exact = case.reference.observe(np.array([0.1, 0.5]))
    >>> [round(float(theta), 6) for theta in exact["theta"]]
    [4.073905, 19.655093]
    """

    system: System
    scene: Scene
    problem: Any  # analytic object of the system
    reference: Reference  # exact motion of the problem
    errors: ErrorTheory  # theory of fixed steps' errors
    # Most samples of a run: enough for a smooth curve. Errors are judged at the samples.
    samples: int = 500

    def lasting(self, duration: float, samples: int = 500) -> Case:
        """Returns the same case with another `duration` [s] and at most `samples` samples. MuJoCo,
        pymunk, scipy and engines that are stepped in the same way heed `samples`."""
        return replace(self, scene=replace(self.scene, duration=duration), samples=samples)
