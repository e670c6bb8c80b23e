"""Where a run has diverged: limits that no motion of a scene reaches, and the cut beyond them."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from typing import Any

import numpy as np

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.engines.trajectory import ByName, Trajectory

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


def limits(problem: Any) -> ByName:
    """Magnitudes of a pendulum's observables that only a diverged run exceeds."""
    return {"theta_dot": BEYOND * fastest(problem)}


def within(trajectory: Trajectory, limits: ByName) -> Trajectory:
    """`trajectory` up to the first sample at which an observable exceeds its limit in magnitude,
    or is not a number; `diverged_at` then says when."""
    lost = np.zeros(len(trajectory.times), dtype=bool)
    for name, values in trajectory.observables.items():
        lost |= ~(np.abs(values) <= limits.get(name, sys.float_info.max))
    if not lost.any():
        return trajectory
    first = int(np.argmax(lost))
    return replace(
        trajectory,
        times=trajectory.times[:first],
        observables={name: values[:first] for name, values in trajectory.observables.items()},
        channels={name: values[:first] for name, values in trajectory.channels.items()},
        diverged_at=float(trajectory.times[first]),
    )
