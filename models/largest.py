"""Magnitudes that no motion of a pendulum reaches: beyond them a run has diverged."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor

# times what is possible: beyond it a run has diverged, below it there is an error
BEYOND = 10.0


def fastest(problem: Any, duration: float = math.inf) -> float:
    """A speed [rad/s] that a pendulum, simple or on a cone, never exceeds within `duration` [s]:
    that of its energy, and what forcing adds before damping takes as much away."""
    rotor: DrivenRotor = getattr(problem, "rotor", None) or problem.motion.rotor
    span = abs(rotor.sin2) + 2 * abs(rotor.cos) + 2 * abs(rotor.sin)  # of V, at most
    spring = rotor.stiffness * problem.theta**2
    free = math.sqrt(problem.theta_dot**2 + spring + 2 * span)
    if rotor.autonomous:
        return free
    lasting = 2.0 / rotor.damping_rate if rotor.damping_rate else math.inf
    return free + abs(rotor.forcing_amplitude) * min(duration, lasting)


def rates_of_a_pendulum(problem: Any) -> Mapping[str, float]:
    """Magnitudes of a pendulum's observables that only a diverged run exceeds."""
    return {"theta_dot": BEYOND * fastest(problem)}
