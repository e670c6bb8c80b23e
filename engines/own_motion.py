"""The interface of an audit: the continuous motion of a model, and the model's own steps."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.trajectory import Timed


@dataclass(frozen=True)
class Start:
    """The state in which a user's model starts: a keyframe, by name or number, or as the model
    stands; with these positions and velocities in place of those."""

    keyframe: int | str | None = None
    qpos: tuple[float, ...] | None = None  # [m, rad], as many as the model has
    qvel: tuple[float, ...] | None = None  # [m/s, rad/s]


AS_IT_STANDS = Start()
Policy = Callable[[float, Array, Array], Any]  # time [s], qpos, qvel -> a number an actuator


@dataclass(frozen=True)
class Script:
    """A start and a control held over periods: what is replayed by the reference and every step."""

    start: Array  # state, shape (n,)
    period: float  # [s], a multiple of the model's own step
    controls: Array  # shape (periods, actuators)

    @property
    def times(self) -> Array:
        """Ends of the periods [s], the start included, shape (periods + 1,)."""
        return np.asarray(self.period * np.arange(len(self.controls) + 1), dtype=float)

    @property
    def duration(self) -> float:
        """[s]"""
        return self.period * len(self.controls)


class Field(Protocol):
    """The continuous motion of a model, y' = f(t, y), under a control that is held."""

    evaluations: int
    """Calls so far."""

    def __call__(self, t: float, y: Array) -> Array:
        """Rates of a state y of shape (n,) at t [s]; raises NotCertifiable."""

    def hold(self, control: Array, t: float, y: Array) -> None:
        """Hold a control, shape (actuators,), from the state `y` at `t` [s] on."""

    def normalised(self, y: Array) -> Array:
        """The state with quaternions of length one."""

    def active(self) -> bytes:
        """Which contacts and limits act in the state of the last call, one that was reached: an
        event is a change. Raises Undecided."""


@dataclass(frozen=True)
class Integration:
    """States at the ends of the periods, shape (periods + 1, n), not numbers from where it ended;
    how it was computed."""

    states: Array
    until: float  # [s] to which it is known
    how: str
    evaluations: int = 0
    events: tuple[float, ...] = ()  # [s] at which contacts or limits begin or cease to act
    why: str = ""  # it ended early
    decided: bool = True  # by more than rounding
    seconds: float = 0.0  # wall time


@dataclass(frozen=True)
class Stepped:
    """The model's own steps: states as in `Integration`."""

    integrator: str
    step: float  # [s]
    states: Array
    seconds: float  # of processor time, of one run
    why: str = ""  # it ended early
    remarks: tuple[str, ...] = ()  # what was noticed on the way


@dataclass(frozen=True)
class Touching:
    """Which pairs of geoms touch at some times of a motion."""

    times: Array  # [s], shape (n,): the model's own steps, or every few where they are many
    pairs: Mapping[str, Array]  # by name, whether they touch then, shape (n,)

    @property
    def events(self) -> int:
        """How often a pair begins or ceases to touch."""
        return sum(int(np.count_nonzero(np.diff(on.astype(int)))) for on in self.pairs.values())

    def intervals(self, pair: str) -> Array:
        """Begins and ends [s] of the times at which a pair touches, shape (k, 2); it ends at the
        first look at which it no longer does."""
        edges = np.diff(np.concatenate([[0], self.pairs[pair].astype(int), [0]]))
        last = self.times[-1:] + np.diff(self.times[-2:])
        times = np.concatenate([self.times, last if last.size else self.times[-1:]])
        return np.stack([times[edges == 1], times[edges == -1]], axis=1)


@dataclass(frozen=True)
class Change:
    """A change of a model: numbers of it, and the values that they are given. A feature is removed
    by those that disable it."""

    name: str
    # Field, indices into its numbers, row by row (none: one of the options), and the value.
    sets: tuple[tuple[str, tuple[int, ...], float], ...]


@dataclass(frozen=True)
class Element:
    """A part of a model whose stiffness or damping may limit the step."""

    name: str  # "actuator kp 2000 on 0.01 kg m^2"
    weaker: Change  # the model with less of it
    remedy: Change | None = None  # what may raise the limit that it sets


@dataclass(frozen=True)
class Place:
    """A joint, or an activation, in some state of a model: what acts on it."""

    name: str  # "joint wrist_3"
    elements: tuple[Element, ...] = ()
    remedies: tuple[Change, ...] = ()  # what may raise any limit that is set there


class StepMaps(Protocol):
    """Jacobians of one step about a state of a model, on its tangent space: positions, velocities
    and activations, n in all."""

    state: Array
    """That state, shape (n,) or more."""

    def at_rest(self, integrator: str, step: float) -> StepMaps | None:
        """Those about a state near by that steps of a size [s] leave as it is, stable or not; None
        where none is found."""

    def __call__(
        self, integrator: str, step: float, difference: float, directions: Array | None = None
    ) -> Array:
        """The Jacobian of one step [s] by central differences of a size [m, rad, ...], shape
        (n, n); times `directions`, shape (n, k), if given."""

    def changed(self, change: Change) -> StepMaps:
        """Those of the model with a change, about the same state."""

    def place(self, weights: Array) -> Place:
        """Where most of the weights of the tangent space, shape (n,), are."""


class OwnModel(Protocol):
    """A user's model, made ready for an audit: as it stands at its own step, contacts clamped as
    the engine clamps them there."""

    @property
    def name(self) -> str:
        """The model's name."""

    @property
    def step(self) -> float:
        """Its own step [s]."""

    @property
    def integrator(self) -> str:
        """Its own integrator."""

    @property
    def integrators(self) -> tuple[str, ...]:
        """Those to try, its own first."""

    @property
    def steppable(self) -> tuple[str, ...]:
        """All that step it, its own first."""

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies."""

    @property
    def clamped(self) -> Mapping[str, int]:
        """{field: how many time constants are raised at its own step}."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Features that are disabled, and other remarks on the model."""

    @property
    def state(self) -> Array:
        """Where it starts, shape (n,)."""

    @property
    def rest(self) -> Array:
        """Controls at the start, shape (actuators,)."""

    @property
    def ranges(self) -> Array:
        """Of the controls, shape (actuators, 2), not numbers where there is none."""

    def option(self, integrator: str, step: float) -> Mapping[str, tuple[str, str]]:
        """{attribute of the file's options: what it is, what to put in its place} for another
        integrator and step [s]."""

    def softened(self, script: Script, integrator: str, parts: int) -> bool:
        """Whether the engine itself would soften contacts at `parts` steps in a period so that this
        motion is another."""

    def field(self, width: float = 0.0) -> Field:
        """Its continuous motion; contacts that begin over a layer of `width` [m], if given."""

    def stepped(self, script: Script, integrator: str, parts: int) -> Stepped:
        """Its own steps, `parts` in a control period."""

    def timed(
        self, script: Script, states: Array, integrator: str, parts: int, steps: int
    ) -> Timed:
        """The first `steps` of `parts` in each period of `script`, begun at its row of `states`, or
        where the last one ended if that is no number, for what they cost."""

    def step_maps(self, state: Array, control: Array) -> StepMaps:
        """Jacobians of its own steps about a state under a control."""

    def nudged(
        self,
        script: Script,
        begin: int,
        integrator: str,
        step: float,
        duration: float,
        after: float = 0.0,
    ) -> float:
        """How many times as far apart as a small nudge are positions, at most, when it has stepped
        for a duration [s], with the controls from the period `begin` on, the last one held for as
        long as need be; infinite where a run diverges. The nudge is one of `script.start`, or of
        where a run from there is `after` a time [s]."""

    def rate_after(self, script: Script, integrator: str, step: float, count: int) -> float:
        """The largest velocity of a degree of freedom [m/s, rad/s] in the last tenth of so many
        steps [s], the last control held for as long as need be; infinite where it diverges."""

    def positions(self, states: Array) -> Array:
        """Centres of mass of the bodies [m], shape (len(states), bodies, 3)."""

    def changes(self, script: Script) -> tuple[Change, ...]:
        """Features to remove, chosen from its own steps under `script`, each to be tried."""

    def changed(self, changes: Sequence[Change]) -> OwnModel:
        """The model with these left out."""

    def readings(self, states: Array) -> Mapping[str, Array]:
        """Energy [J] and violations of contacts, limits and equalities [m or rad] of states, by
        name, each of shape (len(states),); what the model cannot have is left out."""

    def touching(self, script: Script) -> Touching:
        """Which pairs touch when along its own steps."""

    def picture(self) -> bytes | None:
        """A PNG of it at the start; None where this machine draws none."""

    def starts(self, count: int, size: float) -> Array:
        """States near the start, by `size` [m or rad] in each coordinate, the same at each call,
        shape (count, n)."""

    @property
    def names(self) -> Mapping[str, tuple[str, ...]]:
        """Of the numbers that a motion depends on: each "position", "velocity" and "activation" of
        the start, on its tangent space, and each "control"."""

    def shifted(self, state: Array, shift: Array) -> Array:
        """A state moved by positions, velocities and activations of the tangent space."""

    def product(self, script: Script) -> Array:
        """Derivatives of positions at the ends of the periods by all of `names`, multiplied along
        its own steps, shape (periods + 1, positions, names); raises NotCertifiable."""

    def coordinates(self, states: Array, others: Array) -> Array:
        """Differences of two motions in generalised coordinates, rad or m, shape (len(states),
        degrees of freedom)."""


class NotCertifiable(Exception):
    """A model, or a moment, for which no reference can be certified; its text says why."""


class Undecided(NotCertifiable):
    """A motion that rounding decides: contacts over a layer would not help."""
