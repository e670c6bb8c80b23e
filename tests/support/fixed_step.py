"""Fixed-step schemes on the driven rotor in plain floats, to compare the error theory with."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import LEAPFROG, RK4, Scheme


def run(
    rotor: DrivenRotor, theta: float, theta_dot: float, step: float, steps: int, scheme: Scheme
) -> tuple[Array, Array]:
    """Theta and theta_dot at times 0, step ... steps * step."""
    base, held = scheme.integrator, {"start": 0.0, "midpoint": 0.5}.get(scheme.control)
    pull, forcing, xi = _pull(rotor), _forcing(rotor, step, held), rotor.damping_rate
    x, v, h = theta, theta_dot, step
    xs, vs = [x], [v]
    for n in range(steps):
        t = n * h
        if base == RK4:
            early, middle, late = forcing(t, 0.0), forcing(t, 0.5), forcing(t, 1.0)
            a = pull(x) - xi * v + early
            w = v + h / 2 * a
            b = pull(x + h / 2 * v) - xi * w + middle
            u = v + h / 2 * b
            c = pull(x + h / 2 * w) - xi * u + middle
            y = v + h * c
            d = pull(x + h * u) - xi * y + late
            x, v = x + h / 6 * (v + 2 * w + 2 * u + y), v + h / 6 * (a + 2 * b + 2 * c + d)
        elif base == LEAPFROG:
            v += h / 2 * (pull(x) - xi * v + forcing(t, 0.0))
            x += h * v
            v = (v + h / 2 * (pull(x) + forcing(t, 1.0))) / (1 + xi * h / 2)
        elif scheme.position_first:
            x, v = x + h * v, v + h * (pull(x + h * v) - xi * v + forcing(t, 0.0))
        elif scheme.implicit_damping:
            v = (v + h * (pull(x) + forcing(t, 0.0))) / (1 + h * xi)
            x += h * v
        else:
            v += h * (pull(x) - xi * v + forcing(t, 0.0))
            x += h * v
        xs.append(x)
        vs.append(v)
    return np.array(xs), np.array(vs)


def _pull(rotor: DrivenRotor) -> Callable[[float], float]:
    p2, pc, ps, k = rotor.sin2, rotor.cos, rotor.sin, rotor.stiffness
    sin, cos = math.sin, math.cos
    if p2 == pc == k == 0.0:
        return lambda x: -ps * sin(x)
    return lambda x: p2 * sin(2 * x) + pc * cos(x) - ps * sin(x) - k * x


def _forcing(rotor: DrivenRotor, h: float, held: float | None) -> Callable[[float, float], float]:
    size, frequency, phase = (
        rotor.forcing_amplitude,
        rotor.forcing_frequency,
        rotor.forcing_phase,
    )
    if size == 0.0:
        return lambda t, fraction: 0.0
    return lambda t, fraction: (
        size * math.sin(frequency * (t + h * (fraction if held is None else held)) + phase)
    )
