"""Period and action of all motions in a potential as functions of the energy: I(H), Omega(H) =
dH/dI.

Sudakov 2015, eqs. 10 to 13, has rotation only; here each well and the separatrices are included. At
the energy where a libration over both wells begins, its action is the sum of the actions of the two
wells. Where rotation begins, the libration's action is twice that of the rotation, because a
libration's orbit passes both ways.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from plumbob.analytic.numerics.elliptic.motion import solve
from plumbob.analytic.numerics.elliptic.trigonometric_potential import (
    TrigonometricPotential,
    critical_points,
)
from plumbob.analytic.numerics.quad import double
from plumbob.analytic.reference import Array

# Smallest distance from a separatrix, as a fraction of the energy range of a branch
NEAREST_PART = 1e-6


@dataclass(frozen=True)
class Branch:
    """Motions of one kind: its name, energies H [J], periods [s] and actions [J s], shape (n,)
    each."""

    name: str
    energies: Array
    periods: Array
    actions: Array

    @property
    def rates(self) -> Array:
        """Omega = 2 pi/T [rad/s], shape (n,)."""
        return 2 * np.pi / self.periods


def branches(
    potential: TrigonometricPotential, inertia: float, highest: float, points: int = 60
) -> tuple[Branch, ...]:
    """Returns the branches of a pendulum with a moment of inertia [kg m^2] in a `potential` [J], up
    to the energy `highest` [J]. Each has about `points` energies, denser towards the separatrices.
    """
    ends = np.geomspace(NEAREST_PART, 0.5, points // 2)
    numbers = np.concatenate([ends, 1.0 - ends[-2::-1]])  # dense at 0 and at 1
    curves = list[Branch]()
    for energy_range in _energy_ranges(potential, highest):
        low, high = energy_range.lowest, energy_range.highest
        if high > low:
            energies = low + (high - low) * numbers
            start = float(energy_range.angle)
            curves.append(_branch(potential, inertia, energy_range.name, start, energies))
    return tuple(curves)


class _EnergyRange(NamedTuple):
    """Energies of the motions of one branch."""

    name: str
    angle: float  # [rad] an angle that all these motions pass
    lowest: float  # [J]
    highest: float  # [J]


def _energy_ranges(potential: TrigonometricPotential, highest: float) -> list[_EnergyRange]:
    """Returns the energies of each branch, up to the `highest` [J]."""
    critical = critical_points(potential)
    values = np.asarray(double(potential.value(critical)))
    curvatures = np.asarray(double(potential.curvature(critical)))
    angles = np.asarray(double(critical))
    wells = np.flatnonzero(curvatures > 0)
    barriers = np.sort(values[curvatures < 0])
    wells = wells[np.argsort(values[wells])]
    names: tuple[str, ...] = ("in the well",)
    if len(wells) > 1:
        names = ("in the deeper well", "in the shallower well")
    ranges = []
    for name, well in zip(names, wells, strict=False):
        ranges.append(_EnergyRange(name, angles[well], values[well], barriers[0]))
    deepest = angles[wells[0]]
    if len(barriers) > 1 and barriers[1] > barriers[0]:
        ranges.append(_EnergyRange("over both wells", deepest, barriers[0], barriers[1]))
    ranges.append(_EnergyRange("rotation", deepest, barriers[-1], highest))
    return ranges


def _branch(
    potential: TrigonometricPotential, inertia: float, name: str, start: float, energies: Array
) -> Branch:
    """Returns the branch of motions that start at the angle `start` [rad] with the `energies` [J],
    shape (n,)."""
    speeds = np.sqrt(2 * (energies - float(double(potential.value(start)))) / inertia)
    motions = solve(potential, inertia, np.full_like(speeds, start), speeds)
    return Branch(name, energies, np.asarray(double(motions.period)), motions.action)
