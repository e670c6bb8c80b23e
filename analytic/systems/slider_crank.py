"""The slider-crank: a uniform crank and rod, and a slider on a line through the crank's axis.

With crank a, rod l, the crank's angle t from the line, and u = sqrt(l^2 - a^2 sin^2 t), the slider
is at x = a cos t + u, and the rod at the angle b from the line, l sin b = -a sin t, so that
b' = -a cos t t'/u (Uicker, Pennock and Shigley 2017, Theory of Machines and Mechanisms, 2.8). In
one degree of freedom, by Lagrange's equation (Landau and Lifshitz 1976, Mechanics, 5),

    J(t) t'' = -J'(t) t'^2/2 - g a cos t (m_crank + m_rod)/2                                    (1)
    J = m_crank a^2/3 + m_rod (dX^2 + dY^2) + m_rod l^2/12 (db/dt)^2 + m_slider (dx/dt)^2       (2)

with dX and dY the derivatives of the place of the rod's centre. Where the rod is as long as the
crank, u = 0 at t = pi/2: the slider can leave the axis or stay on it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.numerics.smooth.soft_loop import softened
from plumbob.analytic.parameters import ParameterError, finite, non_negative, positive
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import SoftLoop

LENGTHS, MASSES = ("crank", "rod"), ("crank_mass", "rod_mass", "slider_mass")
CONSTANTS = (*LENGTHS, *MASSES, "gravity")


@dataclass(frozen=True)
class SliderCrank:
    """Lengths [m] and masses [kg] of the links under `gravity` [m/s^2], with the crank's `angle`
    [rad] and its rate [rad/s] at time 0; raises ParameterError.

    >>> crank = SliderCrank(0.2, 0.5, 1.0, 1.0, 1.0, 9.81, 1.0, 10.0)
    >>> round(float(crank.motion.observe(np.array([0.5]))["slider"][0]), 6)
    0.441343
    """

    crank: float
    rod: float
    crank_mass: float
    rod_mass: float
    slider_mass: float
    gravity: float
    angle: float
    angular_velocity: float

    def __post_init__(self) -> None:
        for field in fields(self):
            check = positive if field.name in CONSTANTS[:-1] else finite
            check(field.name, getattr(self, field.name))
        non_negative("gravity", self.gravity)
        if self.rod <= self.crank:
            raise ParameterError("rod", self.rod, f"longer than the crank, {self.crank:g} m")

    @cached_property
    def motion(self) -> CertifiedMotion:
        """The exact motion."""
        return CertifiedMotion(
            SmoothSystem(
                ("angle",),
                ("angle_dot",),
                lambda p, q: ((_inertia(p, *q)[0],),),
                _moment,
                {name: getattr(self, name) for name in CONSTANTS},
                (self.angle,),
                (self.angular_velocity,),
                readings=lambda p, q, v: {"slider": _slider(p, q[0])[0]},
            )
        )

    @property
    def opened(self) -> SmoothSystem:
        """Crank and rod with their angles, and the slider on its own, at the same start."""
        place, by_angle, _ = _slider(self, self.angle)
        root = _root(self, self.angle)[0]
        sine = self.crank * math.sin(self.angle)
        rod_rate = -self.crank * math.cos(self.angle) / root * self.angular_velocity
        return SmoothSystem(
            ("angle", "rod_angle", "slider"),
            ("angle_dot", "rod_angle_dot", "slider_dot"),
            _masses,
            _forces,
            self.motion.system.parameters,
            (self.angle, math.atan2(-sine, root), place),
            (self.angular_velocity, rod_rate, by_angle * self.angular_velocity),
        )

    def soft(self, loop: SoftLoop, step: float) -> SmoothSystem:
        """The mechanism with its rod tied to the slider by a soft constraint."""
        stretched = np.linalg.inv(_masses(self, (0.0, 0.0, 0.0)))[:2, :2]
        lever = np.array([self.crank, self.rod / 2])  # of the rod's centre, which can move across
        sees = lever @ stretched @ lever / 3 + 1 / self.slider_mass  # the mean of three directions
        return softened(self.opened, _gaps, loop, step, sees)

    @property
    def lift(self) -> float:
        """Energy [J] that takes crank and rod from the line to the top."""
        return self.gravity * self.crank * (self.crank_mass + self.rod_mass) / 2

    def energy(self, angle: Any, rate: Any) -> Array:
        """Energy [J], 0 for the gravity of a mechanism on its line."""
        inertia, _ = _inertia(self, angle)
        return np.asarray(inertia * rate**2 / 2 + self.lift * np.sin(angle))


def _root(p: Any, t: Any) -> tuple[Any, Any, Any]:
    """u of the header with its two derivatives by the angle."""
    root = np.sqrt((p.rod - p.crank) * (p.rod + p.crank) + (p.crank * np.cos(t)) ** 2)
    first = -(p.crank**2) * np.sin(t) * np.cos(t) / root
    return root, first, -(p.crank**2 * np.cos(2 * t) + first**2) / root


def _slider(p: Any, t: Any) -> tuple[Any, Any, Any]:
    """The slider's distance from the axis with its two derivatives by the angle."""
    root, first, second = _root(p, t)
    sine, cosine = p.crank * np.sin(t), p.crank * np.cos(t)
    return cosine + root, first - sine, second - cosine


def _inertia(p: Any, t: Any) -> tuple[Any, Any]:
    """J of eq. 2 and half its derivative by the angle [kg m^2]."""
    root, first, second = _root(p, t)
    _, x, x_slope = _slider(p, t)
    sine, cosine = p.crank * np.sin(t), p.crank * np.cos(t)
    turn, turn_slope = -cosine / root, (sine + cosine * first / root) / root
    along, along_slope = first / 2 - sine, second / 2 - cosine
    inertia = p.crank_mass * p.crank**2 / 3 + p.slider_mass * x**2
    inertia = inertia + p.rod_mass * (along**2 + cosine**2 / 4 + p.rod**2 * turn**2 / 12)
    slope = along * along_slope - sine * cosine / 4 + p.rod**2 * turn * turn_slope / 12
    return inertia, p.rod_mass * slope + p.slider_mass * x * x_slope


def _moment(p: Any, time: Any, q: Any, v: Any) -> tuple[Any]:
    """The right-hand side of eq. 1 [N m]."""
    weight = p.gravity * p.crank * (p.crank_mass + p.rod_mass) / 2
    return (-_inertia(p, q[0])[1] * v[0] ** 2 - weight * np.cos(q[0]),)


def _masses(p: Any, q: Any) -> tuple[tuple[Any, ...], ...]:
    """Of the opened mechanism: crank and rod as a double pendulum, and the slider."""
    coupling = p.rod_mass * p.crank * p.rod / 2 * np.cos(q[0] - q[1])
    inner = (p.crank_mass / 3 + p.rod_mass) * p.crank**2
    return (
        (inner, coupling, 0.0),
        (coupling, p.rod_mass * p.rod**2 / 3, 0.0),
        (0.0, 0.0, p.slider_mass),
    )


def _forces(p: Any, time: Any, q: Any, v: Any) -> tuple[Any, Any, Any]:
    pull = p.rod_mass * p.crank * p.rod / 2 * np.sin(q[0] - q[1])
    inner = (p.crank_mass / 2 + p.rod_mass) * p.gravity * p.crank
    outer = p.rod_mass * p.gravity * p.rod / 2
    return -pull * v[1] ** 2 - inner * np.cos(q[0]), pull * v[0] ** 2 - outer * np.cos(q[1]), 0.0


def _gaps(p: Any, q: Any, v: Any) -> tuple[Any, Any, Any]:
    """From the slider to the rod's end: along and across the line, with J and J' q'."""
    across = np.sin(q[:2]) * (p.crank, p.rod)
    along = np.cos(q[:2]) * (p.crank, p.rod)
    gap = along.sum() - q[2], across.sum()
    square = np.square(v[:2])
    return gap, ((*-across, -1.0), (*along, 0.0)), (-along @ square, -across @ square)
