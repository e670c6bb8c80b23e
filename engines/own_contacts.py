"""The records of a contact audit: a user's body on a plane, which is slid, turned and pushed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from plumbob.analytic.reference import Array
from plumbob.engines.own_motion import OwnModel, SteppedModel
from plumbob.engines.trajectory import ByName


@dataclass(frozen=True)
class Standing:
    """A user's free body as one rigid piece at rest on a plane. Lengths are relative to the centre
    of mass, along the plane's axes."""

    body: str
    plane: str
    mass: float  # [kg]
    inertia: float  # about the vertical [kg m^2]
    gravity: float  # [m/s^2]
    feet: tuple[str, ...]  # geoms that touch the plane
    points: Array  # contact points [m], shape (n, 2)
    height: float  # height of the centre of mass above the plane [m]
    friction: tuple[float, ...]  # friction coefficient at each point
    torsion: bool  # whether single contacts resist turning or rolling by a moment
    locked: int  # number of joints that are held where they start

    @property
    def coefficient(self) -> float:
        """The friction coefficient of all points; nan if the points differ."""
        least = min(self.friction)
        most = max(self.friction)
        return least if most - least <= 1e-9 * most else float("nan")


@dataclass(frozen=True)
class SlideToRest:
    """The motion of a body that was given a velocity, up to its rest."""

    along: float  # displacement of the centre of mass along the initial velocity [m]
    turn: float  # rotation about the vertical [rad]
    rests: bool  # whether the body had stopped when the run ended


class Floor(Protocol):
    """A user's body that has settled on its plane, with contacts of some kind at some step.

    `SettledFloor` documents the members."""

    feet: tuple[str, ...]
    points: Array

    def slide(
        self, heading: float, speed: float, spin: float, duration: float
    ) -> SlideToRest: ...
    def drift(self, heading: float, acceleration: float, duration: float) -> float: ...


class ContactModel(SteppedModel, Protocol):
    """A user's body with its own contact settings, and with those of `plumbob settings`.

    `MujocoContacts` documents the members."""

    @property
    def method(self) -> str: ...
    @property
    def notes(self) -> tuple[str, ...]: ...
    @property
    def standing(self) -> Standing: ...
    @property
    def stiffness(self) -> float: ...
    @property
    def first_order(self) -> float | None: ...
    @property
    def overshoot(self) -> float: ...
    def let_go(self, speed: float) -> tuple[OwnModel, int, Array]: ...
    def frictions(self) -> ByName: ...
    def own(self, step: float) -> Floor: ...
    def pasted(self, step: float) -> Floor: ...
    def snippet(self) -> str: ...
