"""A stack of cubes at rest: nothing moves, and each cube carries the weight of the cubes
above it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.parameters import ParameterError, check_fields
from plumbob.analytic.reference import Array, LinearResponse, Signals

MAX_CUBES = 100  # largest number of cubes


@dataclass(frozen=True)
class Stack(LinearResponse):
    """A `count` of cubes of edge `size` [m] on a floor under `gravity` [m/s^2]. The lowest has
    `mass` [kg]. Each other cube has the same multiple of the mass below it, and the top one has
    `mass_ratio` times the lowest. Raises ParameterError.

    >>> Stack(3, 0.1, 1.0, 4.0, 10.0).normal_forces.tolist()
    [70.0, 60.0, 40.0]
    """

    count: int
    size: float
    mass: float
    mass_ratio: float
    gravity: float

    def __post_init__(self) -> None:
        check_fields(self, ("count", "size", "mass", "mass_ratio", "gravity"))
        if self.count != round(self.count) or not 2 <= self.count <= MAX_CUBES:
            raise ParameterError("count", self.count, f"a whole number from 2 to {MAX_CUBES}")

    @cached_property
    def masses(self) -> Array:
        """Masses from the lowest cube to the top [kg], shape (count,)."""
        return self.mass * self.mass_ratio ** (np.arange(self.count) / (self.count - 1.0))

    @cached_property
    def normal_forces(self) -> Array:
        """Normal force on the lower face of each cube [N], shape (count,)."""
        return self.gravity * np.cumsum(self.masses[::-1])[::-1]

    @property
    def topples(self) -> float:
        """The slope of a floor [rad] on which the stack tips about an edge, if friction holds it.
        There the common centre of the cubes above some face is over that face's edge."""
        faces = np.arange(self.count)
        moments = np.cumsum((self.masses * (faces + 0.5))[::-1])[::-1] * self.gravity
        centres = moments / self.normal_forces - faces  # above each face, in edges of a cube
        return float(np.arctan(0.5 / centres.max()))

    def observe(self, times: Array) -> Signals:
        """Height `top` [m] of the top cube above its initial place, at `times` [s], shape
        (n,): 0."""
        return {"top": np.zeros(len(times))}

    def uncertainty(self, times: Array) -> Signals:
        """The last place of the stack's height [m], shape (n,)."""
        return {"top": np.full(len(times), ULP * self.count * self.size)}
