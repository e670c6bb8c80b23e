"""The interface of a contact audit: a user's body on its floor, slid, turned and pushed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from plumbob.analytic.reference import Array


@dataclass(frozen=True)
class Standing:
    """A user's free body as one rigid piece at rest on its plane. Lengths are relative to its
    centre of mass, along the plane's axes."""

    body: str
    plane: str
    mass: float  # [kg]
    inertia: float  # about the vertical [kg m^2]
    gravity: float  # [m/s^2]
    feet: tuple[str, ...]  # geoms that touch the plane
    points: Array  # of contact [m], shape (n, 2)
    height: float  # of the centre of mass [m]
    friction: tuple[float, ...]  # coefficient at each point
    torsion: bool  # whether contacts resist a turn, or rolling, by moments of their own
    locked: int  # joints held where they start

    @property
    def coefficient(self) -> float:
        """The friction coefficient of all points; not a number where they differ."""
        least, most = min(self.friction), max(self.friction)
        return least if most - least <= 1e-9 * most else float("nan")


@dataclass(frozen=True)
class Slide:
    """How a body that was given a velocity comes to rest."""

    along: float  # displacement of the centre of mass along the initial velocity [m]
    aside: float  # across it, to the left [m]
    turn: float  # about the vertical [rad]
    rests: bool  # whether it had stopped when the run ended


class Floor(Protocol):
    """The body, settled on its plane under certain contacts at a certain step."""

    @property
    def points(self) -> Array:
        """Contact points as they then are, relative to the centre of mass [m], shape (n, 3)."""

    @property
    def feet(self) -> tuple[str, ...]:
        """Geoms that then touch."""

    def slide(self, heading: float, speed: float, spin: float, duration: float) -> Slide:
        """Let it go at `speed` [m/s] along `heading` [rad], turning at `spin` [rad/s], for
        `duration` [s]."""

    def drift(self, heading: float, acceleration: float, duration: float) -> float:
        """Speed [m/s] over the second half of `duration` [s] under a horizontal force through the
        centre of mass, of `acceleration` [m/s^2] times the mass."""


class ContactModel(Protocol):
    """A user's body with its own contacts, and with those of `plumbob settings`."""

    @property
    def name(self) -> str:
        """The model's name."""

    @property
    def standing(self) -> Standing:
        """The body as it rests under its own contacts."""

    @property
    def step(self) -> float:
        """The model's own step [s]."""

    @property
    def integrator(self) -> str:
        """The model's own integrator."""

    @property
    def method(self) -> str:
        """The method whose settings are pasted."""

    @property
    def stiffness(self) -> float:
        """Natural frequency of one pasted contact times the step, at which the body is stable."""

    @property
    def first_order(self) -> float | None:
        """Error of a stopping distance over the speed that is predicted for the pasted contacts at
        the own step [s], of first order in the step; None where none is."""

    @property
    def overshoot(self) -> float:
        """Largest change of a load on the pasted contacts after a sudden force, over the change at
        which it settles."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Features left out, and other remarks on the model."""

    def own(self, step: float) -> Floor:
        """On its own contacts at `step` [s]; raises NotCertifiable where it does not settle."""

    def pasted(self, step: float) -> Floor:
        """On the pasted contacts, written for `step` [s]; raises NotCertifiable likewise."""

    def picture(self) -> bytes | None:
        """A PNG of the model in its posture; None where this machine draws none."""

    def snippet(self) -> str:
        """Contact settings to paste for the model's own step, its feet by their names."""
