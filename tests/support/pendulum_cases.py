"""The notebook's seven pendulums, three forced ones and the source's cone, for tests."""

import math
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.systems.cone_pendulum import solid_cone
from plumbob.analytic.systems.pendulums.driven_motion import DrivenMotion

DEGREE = math.pi / 180
GRAVITY = 9.8


@dataclass(frozen=True)
class Case:
    """A rotor, its start, and the duration of its motion [s]."""

    rotor: DrivenRotor
    theta: float
    theta_dot: float
    duration: float = 50.0


def _notebook(theta, theta_dot, damping_rate=0.0):
    rotor = DrivenRotor(sin=GRAVITY, damping_rate=damping_rate)
    return Case(rotor, theta * DEGREE, theta_dot * DEGREE)


def _forced(amplitude, frequency, damping_rate, sin, theta):
    return Case(DrivenRotor(0.0, 0.0, sin, damping_rate, amplitude, frequency), theta, 0.0)


def _cone():
    body = solid_cone(8000.0, 0.3, 30 * DEGREE)
    rate = 26.0
    pivot_y = 0.09
    arm = body.mass * body.com_distance / body.inertia_x
    rotor = DrivenRotor(
        sin2=(body.inertia_y - body.inertia_z) * rate**2 / (2 * body.inertia_x),
        cos=pivot_y * arm * rate**2,
        sin=GRAVITY * arm,
    )
    return Case(rotor, 0.0, 37.0, 0.5)


CASES = MappingProxyType(
    {
        "free-small": _notebook(-10, 0),
        "free-large": _notebook(-120, 0),
        "rotating-slow": _notebook(-120, 200),
        "rotating-fast": _notebook(-120, 500),
        "damped-small": _notebook(-10, 0, 0.08),
        "damped-large": _notebook(-120, 0, 0.08),
        "damped-rotating": _notebook(-120, 500, 0.2),
        "forced-small": _forced(0.1, 3.0, 0.08, GRAVITY, 0.0),
        "forced-large": _forced(1.5, 2.8, 0.2, GRAVITY, 0.0),
        "forced-chaotic": _forced(1.5, 2 / 3, 0.5, 1.0, 0.2),
        "cone": _cone(),
    }
)


def motion(case):
    """The case's exact motion."""
    return DrivenMotion(case.rotor, case.theta, case.theta_dot)


def endpoint(case):
    """Theta and theta_dot at the case's end, shape (2,)."""
    return np.ravel(list(motion(case).observe(np.array([case.duration])).values()))
