"""The records of an audit of what holds: a user's bodies at rest on their contacts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from plumbob.engines.own_motion import SteppedModel

if TYPE_CHECKING:  # its module loads scipy
    from plumbob.analytic.systems.coulomb_statics import HeldLoads


@dataclass(frozen=True)
class HeldGroup:
    """Bodies that joints and contacts connect, at rest. The world connects none."""

    bodies: tuple[str, ...]
    loads: HeldLoads
    pairs: tuple[str, ...]  # names of the two geoms of each contact
    coefficients: tuple[float, ...]  # coefficient of sliding friction of each contact; 0: none


@dataclass(frozen=True)
class RestingPlace:
    """The place at which bodies are judged: the start, or where they have settled."""

    groups: tuple[HeldGroup, ...]
    moved: float = 0.0  # [m] largest displacement since the start


@dataclass(frozen=True)
class MeasuredCreep:
    """The creep of bodies under the model's own steps."""

    speed: float  # [m/s] of the fastest corner of a body; infinite if the run diverges
    steady: bool  # whether the speed has become steady
    depth: float  # [m] of the deepest contact
    distances: Mapping[float, float]  # {duration [s]: displacement [m]}, as far as it is run
    step_seconds: float  # [s] processor time of a step


@dataclass(frozen=True)
class FrictionOptions:
    """Options of a model that decide how fast bodies creep."""

    cone: str  # "elliptic" or "pyramidal"
    impratio: float
    noslip_iterations: int = 0


class HeldModel(SteppedModel, Protocol):
    """A user's bodies at rest, under their own steps or under other options.

    `MujocoHeld` documents the members."""

    @property
    def options(self) -> FrictionOptions: ...
    @property
    def refusal(self) -> str: ...
    @property
    def at_start(self) -> RestingPlace: ...
    @property
    def settled(self) -> RestingPlace | None: ...
    def predicted_creep(self) -> float | None: ...
    def creep(self, durations: tuple[float, ...] = ()) -> MeasuredCreep: ...
    def with_options(self, options: FrictionOptions) -> HeldModel: ...
