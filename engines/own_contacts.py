"""The records of a contact audit: a user's body on its floor, slid, turned and pushed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from plumbob.analytic.reference import Array

if TYPE_CHECKING:
    from plumbob.engines.adapters.mujoco.own_model.user_contacts import (
        MujocoContacts,
        SettledFloor,
    )

    ContactModel = MujocoContacts
    Floor = SettledFloor
else:  # of the engine that has the ability `UserModels`
    ContactModel = Floor = Any


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
        least = min(self.friction)
        most = max(self.friction)
        return least if most - least <= 1e-9 * most else float("nan")


@dataclass(frozen=True)
class Slide:
    """How a body that was given a velocity comes to rest."""

    along: float  # displacement of the centre of mass along the initial velocity [m]
    turn: float  # about the vertical [rad]
    rests: bool  # whether it had stopped when the run ended
