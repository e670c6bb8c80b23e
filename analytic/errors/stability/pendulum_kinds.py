"""Kinds of a pendulum's motion: libration in a well, rotation, rest, and others."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plumbob.analytic.errors.stability.largest_step import RESTING_SWING_FRACTION
from plumbob.analytic.numerics.elliptic.trigonometric_potential import (
    TrigonometricPotential,
    crests,
)
from plumbob.analytic.numerics.quad import double
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.reference import Array, Signals

# A swing that is 10 times faster than the exact motion is irregular: chosen. Semi-implicit Euler
# swings faster by 1/sqrt(1 - (h omega)^2/4), which is 10 at h omega = 1.99. Its limit of h omega =
# 2 is therefore found to 1 %.
IRREGULAR_SWING_RATIO = 10.0
SETTLED_SPEED = 0.5  # fraction of its largest speed below which a damped motion has settled
WHOLE_TURN = 2.0 * np.pi  # [rad]
# A change from one of these kinds is a failure. Kinds are given by their first words.
JUDGED_KINDS = ("libration", "rotation", "at rest", "settles")


@dataclass(frozen=True)
class PendulumKinds:
    """Classifier of the motions of a `rotor`; the exact motion's largest rate is `speed`
    [rad/s]."""

    rotor: DrivenRotor
    speed: float

    @cached_property
    def crests(self) -> Array:
        """Angles in [0, 2 pi) [rad] of the potential's maxima, increasing; empty if there are
        none."""
        if self.rotor.linear:
            return np.zeros(0)
        potential = TrigonometricPotential(self.rotor.sin2, self.rotor.cos, self.rotor.sin)
        return np.sort(double(crests(potential)) % WHOLE_TURN)

    def wells(self, theta: Array) -> Array:
        """Returns the number of the well in which each angle [rad] lies; each full turn adds the
        number of wells."""
        turns, within = np.divmod(theta, WHOLE_TURN)
        return turns * len(self.crests) + np.searchsorted(self.crests, within)

    def __call__(self, observed: Signals) -> str:
        """Returns the kind of a motion from samples of `theta` [rad] and `theta_dot` [rad/s].

        The kinds are "libration in well ...", "settles in well ...", "rotation" and "at rest". If
        the rotor is forced, the kind is "forced"; if a sample is not finite, "lost"; else
        "irregular".
        """
        theta = observed["theta"]
        rate = observed["theta_dot"]
        last_quarter = slice(-(len(theta) // 4) or None, None)
        if not (np.isfinite(theta).all() and np.isfinite(rate).all()):
            return "lost"
        if not self.rotor.autonomous:
            return "forced"
        wells = np.unique(self.wells(theta))
        last_wells = np.unique(self.wells(theta[last_quarter]))
        last_speed = np.abs(rate[last_quarter]).max()
        if self.rotor.damping_rate:
            if len(last_wells) == 1 and last_speed <= SETTLED_SPEED * self.speed:
                return f"settles in well {last_wells[0]:.0f}"
            return "irregular"
        if last_speed <= RESTING_SWING_FRACTION * self.speed:
            return "at rest"
        if len(wells) > 1 and ((rate > 0.0).all() or (rate < 0.0).all()):
            return "rotation"
        too_fast = np.abs(rate).max() > IRREGULAR_SWING_RATIO * self.speed
        too_many_wells = len(wells) > max(1, len(self.crests))
        if too_fast or too_many_wells or len(last_wells) < len(wells):
            return "irregular"
        return "libration in well " + " and ".join(f"{well:.0f}" for well in wells)
