"""Where a run has diverged: limits that no motion of a scene reaches, and the cut beyond them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.engines.trajectory import ByName, Trajectory

BEYOND = 10.0  # times what is possible: beyond it a run has diverged, below it there is an error


def possible_speed(rotor: DrivenRotor, theta_dot: float) -> float:
    """A speed [rad/s] that a conservative `rotor` started at `theta_dot` [rad/s] never exceeds."""
    span = abs(rotor.sin2) + 2 * abs(rotor.cos) + 2 * abs(rotor.sin)  # of V, at most
    return float(np.sqrt(theta_dot**2 + 2 * span))


def fastest(problem: Any, duration: float = math.inf) -> float:
    """A speed [rad/s] that a simple_pendulum.SimplePendulum never exceeds within `duration` [s]:
    that of its energy, and what forcing adds before damping takes as much away."""
    rotor: DrivenRotor = problem.rotor
    spring = math.sqrt(rotor.stiffness) * problem.theta
    free = possible_speed(rotor, math.hypot(problem.theta_dot, spring))
    if rotor.autonomous:
        return free
    lasting = 2.0 / rotor.damping_rate if rotor.damping_rate else math.inf
    return free + abs(rotor.forcing_amplitude) * min(duration, lasting)


def limits(problem: Any) -> ByName:
    """Magnitudes of a simple pendulum's observables that only a diverged run exceeds."""
    return {"theta_dot": BEYOND * fastest(problem)}


def limits_on_platform(problem: Any) -> ByName:
    """The same of a cone pendulum."""
    return {"theta_dot": BEYOND * possible_speed(problem.motion.rotor, problem.theta_dot)}


def within(trajectory: Trajectory, limits: ByName) -> Trajectory:
    """`trajectory` up to the first sample at which an observable exceeds its limit in magnitude,
    or is not a number; `diverged_at` then says when."""
    lost = np.zeros(len(trajectory.times), dtype=bool)
    for name, values in trajectory.observables.items():
        lost |= ~(np.abs(values) <= limits.get(name, np.inf)) | ~np.isfinite(values)
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
