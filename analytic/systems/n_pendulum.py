"""A chain of uniform rods that hangs from a fixed axis, by its mass matrix and moments.

Rod i = 1 ... n has the mass m_i, the length l_i, and the angle t_i from the vertical. In its place,
the mass w_i = m_i/2 + m_(i+1) + ... + m_n acts at its lower end (Landau and Lifshitz 1976,
Mechanics, 5, for rods):

    sum_j c_ij l_i l_j cos(t_i - t_j) t_j'' = -sum_j c_ij l_i l_j sin(t_i - t_j) t_j'^2
                                              - g l_i w_i sin t_i                               (1)

c_ij = w_max(i, j) for i != j, c_ii = w_i - m_i/6.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import cos, sin
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.parameters import ParameterError, finite, non_negative, positive
from plumbob.analytic.reference import Signals

MAX_RODS = 20  # largest number of rods: the work of a step grows as the cube
RodNumbers = float | Sequence[float]


@dataclass(frozen=True)
class NPendulum:
    """Rods at `angles` [rad] from the vertical, shape (n,), with `masses` [kg], `lengths` [m] and
    `angular_velocities` [rad/s], each of shape (n,) or one number for all rods, under `gravity`
    [m/s^2]. Raises ParameterError.

    >>> chain = NPendulum(1.0, (0.5, 0.4), 9.81, (1.5, 2.5))
    >>> round(float(chain.motion.observe(np.array([2.0]))["tip_x"][0]), 6)
    0.388415
    """

    masses: RodNumbers
    lengths: RodNumbers
    gravity: float
    angles: Sequence[float]
    angular_velocities: RodNumbers = 0.0

    def __post_init__(self) -> None:
        if not isinstance(self.angles, Sequence) or not 1 <= len(self.angles) <= MAX_RODS:
            raise ParameterError("angles", self.angles, f"a list of 1 to {MAX_RODS} numbers")
        non_negative("gravity", self.gravity)
        for name in ("masses", "lengths", "angles", "angular_velocities"):
            check = positive if name in ("masses", "lengths") else finite
            for value in self.each(name):
                check(name, value)

    def each(self, name: str) -> tuple[Any, ...]:
        """Returns one number of the field `name` for each pendulum. A field that is a single number
        gives the same number n times. Raises ParameterError if the field has another count."""
        value: Any = getattr(self, name)
        count = len(self.angles)
        if not isinstance(value, Sequence) or isinstance(value, str):
            return (value,) * count
        if len(value) != count:
            raise ParameterError(name, value, f"one number, or {count} as there are angles")
        return (*value,)

    @cached_property
    def motion(self) -> CertifiedMotion:
        """The exact motion."""
        numbers = range(1, len(self.angles) + 1)
        parameters = {"gravity": self.gravity}
        for i, mass in zip(numbers, self.each("masses"), strict=True):
            parameters[f"mass_{i}"] = mass
        for i, length in zip(numbers, self.each("lengths"), strict=True):
            parameters[f"length_{i}"] = length
        return CertifiedMotion(
            SmoothSystem(
                coordinates=tuple(f"angle_{i}" for i in numbers),
                rates=tuple(f"angle_{i}_dot" for i in numbers),
                mass_matrix=_masses,
                forces=_moments,
                parameters=parameters,
                position=self.each("angles"),
                rate=self.each("angular_velocities"),
                readings=_tip,
            )
        )

    def potential(self, observed: Signals) -> Any:
        """Returns the potential energy [J], 0 with all rods hanging down."""
        system = self.motion.system
        rods = _rods(system.values, len(self.angles))
        lifts = [
            length * carried * (1 - np.cos(observed[name]))
            for (_, length, carried), name in zip(rods, system.coordinates, strict=True)
        ]
        return self.gravity * sum(lifts)


def _rods(p: Any, count: int) -> list[tuple[Any, Any, Any]]:
    """Returns m_i, l_i and w_i (module docstring) of each rod."""
    rods = []
    below = 0.0 * p.gravity  # mass of the rods below
    for i in range(count, 0, -1):
        mass = getattr(p, f"mass_{i}")
        rods.append((mass, getattr(p, f"length_{i}"), mass / 2 + below))
        below = below + mass
    return rods[::-1]


def _masses(p: Any, q: Any) -> list[list[Any]]:
    """Returns the mass matrix of eq. 1 [kg m^2]."""
    rods = _rods(p, len(q))
    rows = [[(w - m / 6) * length**2] * len(rods) for m, length, w in rods]
    for j, (_, outer, w) in enumerate(rods):
        for i, (_, inner, _) in enumerate(rods[:j]):
            rows[i][j] = rows[j][i] = w * inner * outer * cos(q[i] - q[j])
    return rows


def _moments(p: Any, time: Any, q: Any, v: Any) -> list[Any]:
    """Returns the right-hand side of eq. 1 [N m]."""
    rods = _rods(p, len(q))
    moments = [
        -p.gravity * length * w * sin(t) for (_, length, w), t in zip(rods, q, strict=True)
    ]
    for j, (_, outer, w) in enumerate(rods):
        for i, (_, inner, _) in enumerate(rods[:j]):
            pull = w * inner * outer * sin(q[i] - q[j])
            moments[i] = moments[i] - pull * v[j] ** 2
            moments[j] = moments[j] + pull * v[i] ** 2
    return moments


def _tip(p: Any, q: Any, v: Any) -> Mapping[str, Any]:
    """Returns the position of the last rod's end, from the axis [m]."""
    rods = [(length, t) for (_, length, _), t in zip(_rods(p, len(q)), q, strict=True)]
    return {
        "tip_x": sum(length * sin(t) for length, t in rods),
        "tip_z": -sum(length * cos(t) for length, t in rods),
    }
