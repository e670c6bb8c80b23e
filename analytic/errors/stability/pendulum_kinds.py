"""The kind of a pendulum's motion: libration in which wells, rotation, at rest, or none."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plumbob.analytic.errors.stability.largest_step import QUIET
from plumbob.analytic.numerics.elliptic.trigonometric_potential import (
    TrigonometricPotential,
    crests,
)
from plumbob.analytic.numerics.quad import double
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.reference import Array, Signals

# Chosen: a swing this much faster is of no kind. That of semi-implicit Euler is faster by
# 1/sqrt(1 - (h omega)^2/4): by 10 at h omega = 1.99, so that the limit of 2 stays sharp to 1 %.
FASTER = 10.0
CALM = 0.5  # of its largest speed: what a damped motion settles below
TURN = 2.0 * np.pi
JUDGED = ("libration", "rotation", "at rest", "settles")


@dataclass(frozen=True)
class PendulumKinds:
    """The kinds of motion of `rotor` whose rate reaches `speed` [rad/s]."""

    rotor: DrivenRotor
    speed: float

    @cached_property
    def crests(self) -> Array:
        """Angles in [0, 2 pi) of the potential's maxima, increasing; empty where there are none."""
        if self.rotor.linear:
            return np.zeros(0)
        potential = TrigonometricPotential(self.rotor.sin2, self.rotor.cos, self.rotor.sin)
        return np.sort(double(crests(potential)) % TURN)

    def wells(self, theta: Array) -> Array:
        """Number of the well of each angle [rad], counted on through turns."""
        turns, within = np.divmod(theta, TURN)
        return turns * len(self.crests) + np.searchsorted(self.crests, within)

    def __call__(self, observed: Signals) -> str:
        """The kind of sampled `theta` [rad] and `theta_dot` [rad/s], shape (n,): "libration" or
        "settles" with its wells, "rotation", "at rest"; "forced", "irregular" or "lost" where it is
        of no kind."""
        theta = observed["theta"]
        rate = observed["theta_dot"]
        last = slice(-(len(theta) // 4) or None, None)
        if not (np.isfinite(theta).all() and np.isfinite(rate).all()):
            return "lost"
        if not self.rotor.autonomous:
            return "forced"
        if self.rotor.damping_rate:
            wells = np.unique(self.wells(theta[last]))
            calm = np.abs(rate[last]).max() <= CALM * self.speed
            return (
                f"settles in well {wells[0]:.0f}" if len(wells) == 1 and calm else "irregular"
            )
        if np.abs(rate[last]).max() <= QUIET * self.speed:
            return "at rest"
        wells = np.unique(self.wells(theta))
        if len(wells) > 1 and ((rate > 0.0).all() or (rate < 0.0).all()):
            return "rotation"
        late = np.unique(self.wells(theta[last]))
        faster = np.abs(rate).max() > FASTER * self.speed
        if faster or len(wells) > max(1, len(self.crests)) or len(late) < len(wells):
            return "irregular"
        return "libration in well " + " and ".join(f"{well:.0f}" for well in wells)
