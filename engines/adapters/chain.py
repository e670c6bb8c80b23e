"""Scenes as rigid-body engines take them: bodies in a chain, each on a joint of the one before."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array

Vector = tuple[float, float, float]
ORIGIN = (0.0, 0.0, 0.0)
HINGE, SLIDE, FREE, WELD = "revolute", "prismatic", "free", "weld"
FEW, BLOCK = 256, 4096  # steps whose controls are computed at once, first and at most


@dataclass(frozen=True)
class Link:
    """A body, and its joint on the body before it, or on the world."""

    mass: float  # [kg]
    moments: Array  # about the centre of mass, in the body's axes [kg m^2], shape (3, 3)
    centre: Vector = ORIGIN  # of mass, from the joint [m]
    joint: str = HINGE
    axis: Vector = (1.0, 0.0, 0.0)
    place: Vector = ORIGIN  # of the joint in the body before [m]
    position: float = 0.0  # at the start [rad] or [m]
    rate: float = 0.0  # [rad/s] or [m/s]
    damping: float = 0.0  # [N m s]
    stiffness: float = 0.0  # [N m/rad]
    hold: float = 0.0
    """Of a joint whose motion is prescribed, the inertia by which an engine may impose it [kg m^2]
    or [kg]; 0 of others."""


def by_step(
    rows: Callable[[Array, float], Array], step: float, count: int = FEW
) -> Iterator[Any]:
    """The rows of steps of `step` [s], given their indices, one by one, without end: `count` at
    once, then more, so that a few steps do not pay for many."""
    first = 0.0
    while True:
        yield from rows(np.arange(first, first + count), step).tolist()
        first = first + count
        count = min(2 * count, BLOCK)
