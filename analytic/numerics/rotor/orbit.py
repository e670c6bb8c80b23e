"""The driven rotor as a smooth system, and any exact motion of it as a smooth motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import astuple, fields
from typing import Any

import numpy as np

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.smooth.smooth_motion import SmoothMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.reference import Array, Reference

ANGLE = ("theta", "theta_dot")


def forces(rotor: DrivenRotor, library: Any = np) -> Callable[..., tuple[Any]]:
    """The acceleration of `rotor`, of its coefficients, a time, an angle and a rate, in any
    arithmetic in which `library` has a sine and a cosine."""

    def acceleration(p: Any, t: Any, q: Any, v: Any) -> tuple[Any]:
        (theta,), (rate,), total = q, v, 0.0
        if not rotor.linear:
            sine = library.sin(theta)
            total = (2.0 * p.sin2 * sine + p.cos) * library.cos(theta) - p.sin * sine
        total = total - p.stiffness * theta - p.damping_rate * rate
        if not rotor.autonomous:
            push = library.sin(p.forcing_frequency * t + p.forcing_phase)
            total = total + p.forcing_amplitude * push
        return (total,)

    return acceleration


def smooth_system(rotor: DrivenRotor, theta: float, theta_dot: float) -> SmoothSystem:
    """The equation of `rotor` from `theta` [rad] and `theta_dot` [rad/s]."""
    names = [field.name for field in fields(rotor)]
    return SmoothSystem(
        ("theta",),
        ("theta_dot",),
        lambda p, q: ((1.0 + 0.0 * q[0],),),
        forces(rotor),
        dict(zip(names, astuple(rotor), strict=True)),
        (theta,),
        (theta_dot,),
        rotor.damping_rate > 0.0,
    )


def named(times: Array, states: Array) -> Mapping[str, Array]:
    """The state itself as observables."""
    return dict(zip(ANGLE, states, strict=True))


def rotor_motion(
    rotor: DrivenRotor,
    start: Array,
    motion: Reference,
    tilt: float = 0.0,
    read: Callable[[Array, Array], Mapping[str, Array]] = named,
) -> SmoothMotion:
    """An exact `motion` from the `start`, (theta, theta_dot), whose angle in the equation of
    `rotor` is theta plus a `tilt` [rad]."""

    def slope(times: Array, states: Array) -> Array:
        theta, rate = states
        return np.stack([rate, rotor.acceleration(times, theta + tilt, rate)])

    def jacobian(times: Array, states: Array) -> Array:
        stiffness = rotor.slope(states[0] + tilt)
        zero = np.zeros_like(stiffness)
        return np.array([[zero, zero + 1.0], [stiffness, zero - rotor.damping_rate]])

    def state(times: Array) -> Array:
        observed = motion.observe(times)
        return np.stack([observed[name] for name in ANGLE])

    fastest = abs(float(start[1])) + 2 * rotor.rate()
    return SmoothMotion(start, slope, jacobian, state, fastest, read)
