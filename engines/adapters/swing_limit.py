"""How fast a simple pendulum's motion can be: what is far beyond has diverged."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.engines.adapters.divergence import BEYOND, possible_speed


def fastest(problem: Any, duration: float = math.inf) -> float:
    """A speed [rad/s] that a simple_pendulum.SimplePendulum never exceeds within
    `duration` [s]: that of its energy, and what forcing adds before damping takes as much away."""
    rotor: DrivenRotor = problem.rotor
    spring = math.sqrt(rotor.stiffness) * problem.theta
    free = possible_speed(rotor, math.hypot(problem.theta_dot, spring))
    if rotor.autonomous:
        return free
    lasting = 2.0 / rotor.damping_rate if rotor.damping_rate else math.inf
    return free + abs(rotor.forcing_amplitude) * min(duration, lasting)


def limits(problem: Any) -> Mapping[str, float]:
    """Magnitudes of observables that only a diverged run exceeds."""
    return {"theta_dot": BEYOND * fastest(problem)}
