"""Any smooth system as an equation of motion, from its mass matrix and forces."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.equation import Equation
from plumbob.engines.method import Method


def build(problem: Any, method: Method) -> Equation:
    """The equation M(q) q'' = f(t, q, q'); `problem.motion` is a CertifiedMotion. The scale of the
    rates is the larger of two values: the largest rate at the start, and the rate of the fastest
    small deviation of 1 rad or 1 m."""
    system = problem.motion.system
    values = system.values
    start = system.start[:, None]
    several = len(system.coordinates) > 1

    def acceleration(time: float, q: Any, v: Any) -> Any:
        """q'' at a time [s]."""
        if several:
            return np.array(system.acceleration(time, q.tolist(), v.tolist(), values))
        return float(system.acceleration(time, (q,), (v,), values)[0])

    jacobian = system.jacobian(0.0, start)[..., 0]
    fastest_rate = float(np.abs(np.linalg.eigvals(jacobian)).max())
    position = np.array(system.position) if several else system.position[0]
    rate = np.array(system.rate) if several else system.rate[0]

    def read(positions: Array, rates: Array) -> Any:
        """The observables that are neither coordinates nor rates."""
        return system.readings(values, positions, rates)

    return Equation(
        acceleration,
        position,
        rate,
        speed=max(fastest_rate, *map(abs, system.rate)),
        names=system.coordinates,
        rate_names=system.rates,
        read=read,
    )
