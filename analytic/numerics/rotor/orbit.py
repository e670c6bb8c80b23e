"""The driven rotor as a smooth system, and its motion on steps for what follows along it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import astuple, dataclass, fields
from typing import Any

import numpy as np

from plumbob.analytic.numerics.collocation import TimeGrid
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.linear_oscillator import linear_oscillator
from plumbob.analytic.numerics.smooth.certified_motion import integrated
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.parameters import ParameterError, finite, positive
from plumbob.analytic.reference import Array

PARTS = 4  # of a step of Gauss collocation with twice as many nodes
MOST_STEPS = 2**20  # of a linear motion, one in each of its fastest time constants


@dataclass(frozen=True)
class Orbit(TimeGrid):
    """A motion from time 0 on, and steps on which it is smooth."""

    motion: Callable[[Array], tuple[Array, Array]]

    def at(self, times: Array) -> tuple[Array, Array]:
        """Theta [rad] and theta_dot [rad/s] at `times` [s], any shape, within the duration.
        Raises ParameterError."""
        self.locate(times)
        return self.motion(np.asarray(times, dtype=float))


def smooth_system(rotor: DrivenRotor, theta: float, theta_dot: float) -> SmoothSystem:
    """The equation of `rotor` from `theta` [rad] and `theta_dot` [rad/s]."""

    def forces(p: Any, t: Any, q: Any, v: Any) -> tuple[Any]:
        sine = np.sin(q[0])
        total = (2.0 * p.sin2 * sine + p.cos) * np.cos(q[0]) - p.sin * sine
        total = total - p.stiffness * q[0] - p.damping_rate * v[0]
        if not rotor.autonomous:
            push = np.sin(p.forcing_frequency * t + p.forcing_phase)
            total = total + p.forcing_amplitude * push
        return (total,)

    names = [field.name for field in fields(rotor)]
    return SmoothSystem(
        ("theta",),
        ("theta_dot",),
        lambda p, q: ((1.0 + 0.0 * q[0],),),
        forces,
        dict(zip(names, astuple(rotor), strict=True)),
        (theta,),
        (theta_dot,),
        rotor.damping_rate > 0.0,
    )


def steps_until(rotor: DrivenRotor, duration: float) -> int:
    """Steps in which a linear motion is followed for `duration` [s]; raises ParameterError."""
    if not (count := duration * rotor.rate()) <= MOST_STEPS:
        raise ParameterError("duration", duration, "shorter: the motion is too fast")
    return math.ceil(count) or 1


def integrate(rotor: DrivenRotor, theta: float, theta_dot: float, duration: float) -> Orbit:
    """Motion of `rotor` from `theta` [rad], `theta_dot` [rad/s] for `duration` [s], by Gauss
    collocation, or in closed form where that is linear. Raises ParameterError."""
    finite("theta", theta), finite("theta_dot", theta_dot), positive("duration", duration)
    if (oscillator := linear_oscillator(rotor)) is not None:
        edges = np.linspace(0.0, duration, steps_until(rotor, duration) + 1)
        return Orbit(edges, lambda times: oscillator.motion(theta, theta_dot, times))
    system, size = smooth_system(rotor, theta, theta_dot), np.array([1.0, rotor.rate()])
    solution = integrated(system, duration, size)

    def motion(times: Array) -> tuple[Array, Array]:
        states = solution.at(times.ravel())[:, :, 0].T.reshape(2, *times.shape)
        return states[0], states[1]

    steps = solution.orbit.breakpoints
    parts = steps[:-1, None] + np.diff(steps)[:, None] * (np.arange(PARTS) / PARTS)
    parts = parts.ravel()
    return Orbit(np.append(parts[parts < duration], duration), motion)
