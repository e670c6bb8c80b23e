"""The records of an audit: a start, controls, the continuous motion, and the model's own steps."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import FunctionType
from typing import Any, Literal, Protocol

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.engines.drawn_mechanism import DrawnMechanism
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.peer_model import Layout, Terms
from plumbob.engines.recorded_step import RecordedSteps, StepInput
from plumbob.engines.stepper import Stepper
from plumbob.engines.trajectory import TimedSimulation


@dataclass(frozen=True)
class Start:
    """The state in which a user's model starts: a keyframe, by name or number, or the default state
    of the model. Positions and velocities that are given replace those of that state."""

    keyframe: int | str | None = None
    qpos: Sequence[float] | None = None  # [m, rad] as many as the model has
    qvel: Sequence[float] | None = None  # [m/s, rad/s]


AS_IT_STANDS = Start()
# Relative rounding of a number of periods: 0.3 s has 3 periods of 0.1 s, even if 0.3/0.1 is rounded
# up
PERIOD_ROUNDING = 1e-9
OUT_OF_TIME = "the time given for it ended"
# From time [s], qpos and qvel, or from an observation, to a number for each actuator
Policy = Callable[..., Any]


def policy_name(policy: Policy) -> str:
    """Returns the name of a function, or the class name of another object, whose own name may be
    anything."""
    return policy.__name__ if isinstance(policy, FunctionType) else type(policy).__name__


RunControls = Callable[[float, Array], Array]
"""The controls of one run, shape (actuators,), from the time [s] and the run's own state, shape
(n,), at the begin of a period."""


MovesData = Callable[[Any, Array], None]
"""Moves an mjData through a control period under controls, shape (actuators,). Raises Diverged."""


class NotControlled(Exception):
    """A policy gives a run no finite control; the text says when."""


class AskedPolicy(Protocol):
    """A policy that is asked in the loop."""

    def new_run(self) -> RunControls:
        """Returns the controls of a new run, which raise NotControlled and ParameterError."""

    def check_memory(self, times: Array, states: Array, controls: Array) -> None:
        """Raises ParameterError unless a new run gets the `controls` again, shape (n, actuators),
        at the same times [s] and states, shape (n, k)."""


@dataclass(frozen=True)
class Script:
    """A start and controls held over periods. The reference and all steps replay the controls, or,
    in a loop, ask a policy with their own states."""

    start: Array  # state, shape (n,)
    period: float  # [s] a multiple of the model's own step
    # Shape (periods, actuators). In a loop: the controls of one run, for uses that replay them.
    controls: Array
    loop: AskedPolicy | None = None  # None: all runs replay the controls

    @property
    def replayed(self) -> Script:
        """The script whose controls are replayed by all runs."""
        return replace(self, loop=None)

    def new_run(self) -> Callable[[int, Array], Array]:
        """Returns the controls of a new run, as a function of the number of a period and of the
        run's state at its begin, shape (n,)."""
        if self.loop is None:
            return lambda period, state: self.controls[period]
        ask = self.loop.new_run()
        return lambda period, state: ask(period * self.period, state)

    @property
    def times(self) -> Array:
        """The ends of the periods [s], including the start, shape (periods + 1,)."""
        return np.asarray(self.period * np.arange(len(self.controls) + 1), dtype=float)

    @property
    def duration(self) -> float:
        """The duration of all periods [s]."""
        return self.period * len(self.controls)

    def parts(self, step: float) -> int:
        """Returns the number of steps [s] in a period."""
        return round(self.period / step)


@dataclass(frozen=True)
class Integration:
    """States at the ends of the periods, shape (periods + 1, n), with NaN after an early end."""

    states: Array
    until: float  # [s] time up to which the motion is known
    # [s] times at which contacts or limits begin or cease to act
    events: tuple[float, ...] = ()
    why: str = ""  # why it ended early; empty if it did not
    # Controls of the periods, shape (periods, actuators), with NaN after an early end; empty for a
    # motion of which the start alone is known
    controls: Array = field(default_factory=lambda: np.zeros((0, 0)))


@dataclass(frozen=True)
class Stepped:
    """A run of the model's own steps, with states like those of `Integration`."""

    step: float  # [s]
    states: Array
    seconds: float  # [s] processor time of one run
    why: str = ""  # why it ended early; empty if it did not
    remarks: tuple[str, ...] = ()  # remarks about the run
    # Controls of the periods, shape (periods, actuators), with NaN after an early end; empty if
    # they are not kept
    controls: Array = field(default_factory=lambda: np.zeros((0, 0)))


@dataclass(frozen=True)
class HeldContacts:
    """The contacts of a state in which the friction force is well inside its cone, so that Coulomb
    friction would hold them."""

    velocity: float  # [m/s or rad/s] the largest generalised velocity of the state
    depth: float  # [m] depth of the deepest contact; 0 if there is none
    deepest_geoms: str  # names of the two geoms of the deepest contact
    softness: Mapping[str, str]  # {setting on which the depth depends: its value in the model}
    drift: float  # [m/s] slip of the contact that slips fastest; 0 if there is none
    drifting_geoms: str  # names of the two geoms of the contact that slips fastest
    regularisation: Mapping[str, str]  # {setting on which the drift depends: its value}


@dataclass(frozen=True)
class Change:
    """A change of a model: some of its numbers, and their new values. A feature is removed by the
    values that disable it."""

    name: str
    # (field, indices into the field's numbers in the order of rows, value); an option has no
    # indices
    sets: tuple[tuple[str, tuple[int, ...], float], ...]


@dataclass(frozen=True)
class FileFix:
    """The advised changes of a model file."""

    options: Mapping[str, str]  # {attribute of the file's options: its new value}
    unguarded: bool  # whether refsafe is to be disabled
    raised: tuple[str, ...]  # arrays of time constants of the compiled model, to be raised
    raised_to: float  # [s] smallest time constant of a raised array


FixPlace = Literal["own option", "new option", "new mujoco"]
"""The place of a fix's options in a file: in the file's last <option>, in a new <option> at the end
of <mujoco>, or in a new <mujoco> at the end of the <robot> of a URDF file."""


@dataclass(frozen=True)
class Element:
    """A part of a model whose stiffness or damping may limit the step."""

    name: str  # "actuator kp 2000 on 0.01 kg m^2"
    weaker: Change  # the change that weakens it
    remedy: Change | None = None  # the change that may raise the limit that it sets


@dataclass(frozen=True)
class Place:
    """A joint, or an activation, in some state of a model, and the elements that act on it."""

    name: str  # "joint wrist_3"
    elements: tuple[Element, ...] = ()
    remedies: tuple[Change, ...] = ()  # changes that may raise any limit that is set there


VariationKind = Literal["jacobian", "converged", "solver", "flag", "sleep"]


@dataclass(frozen=True)
class ModelVariation:
    """A model with a changed setting, which should not change the motion, but for rounding and for
    what the solver's tolerance leaves."""

    name: str  # "sparse Jacobian"
    kind: VariationKind
    model: OwnModel
    # The model without the change: the user's model or, if the kind is "converged", the user's
    # model with a solver that converges
    unchanged: OwnModel


class SteppedModel(Protocol):
    """A user's model with a name, its step [s] and its integrator."""

    @property
    def name(self) -> str: ...
    @property
    def step(self) -> float: ...
    @property
    def integrator(self) -> str: ...


class OwnModel(SteppedModel, Protocol):
    """A user's model made ready for an audit, in the engine that has the ability `UserModels`.

    A state has the numbers qpos, qvel and act, shape (n,). `MujocoModel` documents the members."""

    @property
    def integrators(self) -> tuple[str, ...]: ...
    @property
    def steppable(self) -> tuple[str, ...]: ...
    @property
    def clamped(self) -> Mapping[str, int]: ...
    @property
    def notes(self) -> tuple[str, ...]: ...
    @property
    def fields(self) -> Mapping[str, str]: ...
    @property
    def format(self) -> str: ...
    @property
    def file(self) -> Path | None: ...
    @property
    def begin(self) -> Start: ...
    @property
    def bodies(self) -> tuple[str, ...]: ...
    @property
    def state(self) -> Array: ...
    @property
    def rest(self) -> Array: ...
    @property
    def ranges(self) -> Array: ...
    @property
    def unchecked(self) -> tuple[str, ...]: ...
    @property
    def layout(self) -> Layout: ...
    @property
    def names(self) -> Mapping[str, tuple[str, ...]]: ...
    @property
    def activations(self) -> slice: ...
    @property
    def corner_bodies(self) -> Array: ...
    @property
    def drawn(self) -> DrawnMechanism: ...
    def option(self, integrator: str, step: float) -> Mapping[str, tuple[str, str]]: ...
    def softened(self, step: float) -> bool: ...
    def softens(self, script: Script, integrator: str, parts: int) -> bool: ...
    def clamping_acts(self, script: Script) -> bool: ...
    def stepper(self, integrator: str, step: float) -> Stepper: ...
    def function_stepper(self, integrator: str, step: float) -> Stepper: ...
    def as_stepped(self) -> Any: ...
    def recorded_steps(self, integrator: str, step: float) -> RecordedSteps: ...
    def variations(self) -> Iterator[ModelVariation]: ...
    def touching_in(
        self, port: Any, before: StepInput, others: tuple[Any, ...]
    ) -> tuple[Any, ...]: ...
    def batch(self, states: Array, controls: Array, threads: int) -> Array: ...
    def place(self, state: Array, control: Array, weights: Array) -> Place: ...
    def field(self, width: float = 0.0) -> Any: ...
    def hidden_touches(self, field: Any, start: Array) -> Any: ...
    def mechanism(self) -> Mechanism: ...
    def terms(self) -> Callable[[Array, Array], Terms]: ...
    def stepped(
        self, script: Script, integrator: str, parts: int, single: bool = False
    ) -> Stepped: ...
    def timed(
        self, script: Script, states: Array, integrator: str, parts: int, steps: int
    ) -> TimedSimulation: ...
    def moving_data(self, integrator: str, period: float, parts: int) -> MovesData: ...
    def place_data(self, data: Any, state: Array) -> None: ...
    def recorded(self, loop: AskedPolicy, period: float, duration: float) -> Array: ...
    def changes(self, script: Script) -> tuple[Change, ...]: ...
    def touched(self, script: Script) -> Iterator[tuple[int, Array]]: ...
    def changed(self, changes: Sequence[Change]) -> OwnModel: ...
    def with_integrators(self, integrators: tuple[str, ...]) -> OwnModel: ...
    def corners(self, states: Array) -> Array: ...
    def poses(self, states: Array) -> Array: ...
    def readings(self, states: Array) -> Signals: ...
    def held_contacts(self, state: Array, control: Array) -> HeldContacts: ...
    def shifted(self, state: Array, shift: Array) -> Array: ...
    def coordinates(self, states: Array, others: Array) -> Array: ...


def periods(duration: float, period: float) -> int:
    """Returns the number of periods [s] that reach the end of a duration [s], at least one."""
    return max(1, math.ceil(duration / period * (1.0 - PERIOD_ROUNDING)))


class NotCertifiable(Exception):
    """No reference can be certified for a model, or for a time of its motion; the text says why."""
