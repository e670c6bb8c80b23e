"""Period and action of all motions in a potential as functions of the energy: I(H), Omega(H) =
dH/dI.

Sudakov 2015, eqs. 10 to 13, has rotation only; here each well and the separatrices are included. At
the energy where a libration over both wells begins, its action is the sum of the actions of the two
wells. Where rotation begins, the libration's action is twice that of the rotation, because a
libration's orbit passes both ways.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.elliptic.motion import solve
from plumbob.analytic.numerics.elliptic.trigonometric_potential import (
    TrigonometricPotential,
    critical_points,
)
from plumbob.analytic.numerics.quad import double
from plumbob.analytic.reference import Array

NEAREST = 1e-6  # smallest distance from a separatrix over the energy range of a branch


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
    angles = critical_points(potential)
    value, bend = (
        np.asarray(double(x)) for x in (potential.value(angles), potential.curvature(angles))
    )
    places = np.asarray(double(angles))
    wells = np.flatnonzero(bend > 0)
    levels = np.sort(value[bend < 0])
    wells = wells[np.argsort(value[wells])]
    names = (
        ("in the deeper well", "in the shallower well") if len(wells) > 1 else ("in the well",)
    )
    spans = [(names[i], places[w], value[w], levels[0]) for i, w in enumerate(wells)]
    if len(levels) > 1 and levels[1] > levels[0]:
        spans.append(("over both wells", places[wells[0]], levels[0], levels[1]))
    spans.append(("rotation", places[wells[0]], levels[-1], highest))
    return tuple(
        _branch(potential, inertia, name, float(start), low + (high - low) * _dense(points))
        for name, start, low, high in spans
        if high > low
    )


def _dense(points: int) -> Array:
    """Returns numbers from NEAREST to 1 - NEAREST, dense at both ends."""
    ends = np.geomspace(NEAREST, 0.5, points // 2)
    return np.concatenate([ends, 1.0 - ends[-2::-1]])


def _branch(
    potential: TrigonometricPotential, inertia: float, name: str, start: float, energies: Array
) -> Branch:
    """Returns the branch of motions that start at the angle `start` [rad] with the `energies` [J],
    shape (n,)."""
    speeds = np.sqrt(2 * (energies - float(double(potential.value(start)))) / inertia)
    motions = solve(potential, inertia, np.full_like(speeds, start), speeds)
    return Branch(name, energies, np.asarray(double(motions.period)), motions.action)
