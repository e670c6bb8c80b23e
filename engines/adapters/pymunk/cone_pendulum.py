"""The cone pendulum in pymunk: a wheel under a torque that depends on its angle.

pymunk is an engine of the plane and has no rotating platform: the centrifugal moments about the
axle, and the weight's, are applied as a torque.
"""

from __future__ import annotations

import math
from typing import Any

from plumbob.engines.adapters.pymunk.simulation import Translation
from plumbob.engines.adapters.pymunk.wheel import wheel
from plumbob.engines.method import Method
from plumbob.models.largest import rates_of_a_pendulum


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a ConePendulum."""
    problem = problem.started
    body = problem.body
    square = problem.platform_rate**2
    arm = body.mass * body.com_distance
    spread: float = (body.inertia_y - body.inertia_z) * square
    product: float = body.inertia_yz * square
    lever: float = arm * problem.pivot_y * square
    weight: float = arm * problem.gravity

    def torque(theta: float, rate: float) -> float:
        """Of the Lagrangian (Sudakov 2015, eq. 7), with a product of inertia [N m]."""
        sine = math.sin(theta)
        cosine = math.cos(theta)
        return (spread * sine + lever) * cosine - weight * sine + product * math.cos(2 * theta)

    return wheel(problem, body.inertia_x, rates_of_a_pendulum(problem), torque=torque)
