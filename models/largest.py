"""Magnitudes that no motion of a pendulum reaches: a run that exceeds them has diverged."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor

# Ratio to the largest possible magnitude: above it a run has diverged, below it it has an error.
DIVERGED_RATIO = 10.0


def fastest_rate(problem: Any, duration: float = math.inf) -> float:
    """Returns a speed [rad/s] that a pendulum, simple or on a cone, never exceeds within `duration`
    [s]. It is the speed by the energy at the start, plus what the forcing adds before damping
    removes as much."""
    rotor: DrivenRotor = getattr(problem, "rotor", None) or problem.motion.rotor
    # Upper bound on the range of the potential V.
    span = abs(rotor.sin2) + 2 * abs(rotor.cos) + 2 * abs(rotor.sin)
    spring = rotor.stiffness * problem.theta**2
    free = math.sqrt(problem.theta_dot**2 + spring + 2 * span)
    if rotor.autonomous:
        return free
    # After this time [s] damping removes as much speed as forcing adds.
    forcing_time = 2.0 / rotor.damping_rate if rotor.damping_rate else math.inf
    return free + abs(rotor.forcing_amplitude) * min(duration, forcing_time)


def largest_pendulum_rates(problem: Any) -> Mapping[str, float]:
    """Returns magnitudes of a pendulum's observables that only a diverged run exceeds."""
    return {"theta_dot": DIVERGED_RATIO * fastest_rate(problem)}
