"""The records of an audit: a start, controls, the continuous motion, and the model's own steps."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import FunctionType
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbob.analytic.reference import Array

if TYPE_CHECKING:
    from plumbob.engines.adapters.mujoco.own_model.field import ContinuousField
    from plumbob.engines.adapters.mujoco.own_model.model import MujocoModel

    Field = ContinuousField
    OwnModel = MujocoModel
else:  # of the engine that has the ability `UserModels`
    Field = OwnModel = Any


@dataclass(frozen=True)
class Start:
    """The state in which a user's model starts: a keyframe, by name or number, or as the model
    stands; with these positions and velocities in place of those."""

    keyframe: int | str | None = None
    qpos: Sequence[float] | None = None  # [m, rad], as many as the model has
    qvel: Sequence[float] | None = None  # [m/s, rad/s]


AS_IT_STANDS = Start()
ROUNDING = 1e-9  # relative: 0.3 s has 3 periods of 0.1 s, even if 0.3/0.1 is rounded up
OUT_OF_TIME = "the time given for it ended"
Policy = Callable[..., Any]  # time [s], qpos, qvel, or an observation -> a number an actuator


def policy_name(policy: Policy) -> str:
    """The name of a function; of another object that of its class, as its own may be anything."""
    return policy.__name__ if isinstance(policy, FunctionType) else type(policy).__name__


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


@dataclass(frozen=True)
class Integration:
    """States at the ends of the periods, shape (periods + 1, n), NaN from where it ended."""

    states: Array
    until: float  # [s] to which it is known
    events: tuple[float, ...] = ()  # [s] at which contacts or limits begin or cease to act
    why: str = ""  # it ended early


@dataclass(frozen=True)
class Stepped:
    """The model's own steps: states as in `Integration`."""

    step: float  # [s]
    states: Array
    seconds: float  # of processor time, of one run
    why: str = ""  # it ended early
    remarks: tuple[str, ...] = ()  # what was noticed on the way


@dataclass(frozen=True)
class Solid:
    """A geom of a model: the convex hull of points [m], shape (n, 3), about the centre of mass of
    its body and in the body's axes, thickened by a radius [m]; of body 0 in the world's."""

    body: int
    points: Array
    radius: float


@dataclass(frozen=True)
class HeldContacts:
    """The contacts of a state in which the friction force is well inside its cone, so that Coulomb
    friction would hold them."""

    velocity: float  # [m/s or rad/s] the largest generalised velocity of the state
    depth: float  # [m] of the deepest contact; 0 if there is none
    deepest: str  # its two geoms
    softness: Mapping[str, str]  # {setting of the model that makes the depth: its value}
    drift: float  # [m/s] slip of the fastest contact; 0 if there is none
    drifting: str  # its two geoms
    regularisation: Mapping[str, str]  # {setting of the model that makes the drift: its value}


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


def periods(duration: float, period: float) -> int:
    """How many periods [s] it takes to reach the end of a duration [s], at least one."""
    return max(1, math.ceil(duration / period * (1.0 - ROUNDING)))


class NotCertifiable(Exception):
    """A model, or a moment, for which no reference can be certified; its text says why."""
