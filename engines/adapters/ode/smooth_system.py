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
        if several:
            return np.array(system.acceleration(time, q.tolist(), v.tolist(), values))
        return float(system.acceleration(time, (q,), (v,), values)[0])

    pace = np.abs(np.linalg.eigvals(system.jacobian(0.0, start)[..., 0])).max()
    q, v = (np.array(part) if several else part[0] for part in (system.position, system.rate))

    def read(positions: Array, rates: Array) -> Any:
        return system.readings(values, positions, rates)

    return Equation(
        acceleration,
        q,
        v,
        max(float(pace), *map(abs, system.rate)),
        names=system.coordinates,
        rate_names=system.rates,
        read=read,
    )
