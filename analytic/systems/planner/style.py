"""How the turns and lines of a plan are made: as quickly as the limits allow, or simply."""

from __future__ import annotations

import math
from dataclasses import dataclass

from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.analytic.systems.planner.problem import Limits


@dataclass(frozen=True)
class Style:
    """Accelerations of manoeuvres: `w1` and `w2` of lines [m/s^2], the largest Z of turns
    [rad/s^2]; with `equal` all turns are equal, and all lines, and as few as possible."""

    w1: float
    w2: float
    turn: float
    equal: bool

    def turn_acceleration(self, limits: Limits, swing: float) -> float:
        """Z for a turn through `swing` [rad], positive. The largest |w| is at half time, where the
        slider's centripetal acceleration is a Z times its whole angle."""
        allowed = limits.acceleration / (limits.radius * math.hypot(1.0, swing))
        return min(self.turn, allowed)


def quickest(capsule: Capsule, limits: Limits) -> Style:
    """The largest accelerations within the limits."""
    w2 = limits.holding * capsule.holding_acceleration
    return Style(limits.acceleration, w2, math.inf, equal=False)


def simple(capsule: Capsule, limits: Limits) -> Style:
    """Equal manoeuvres of common accelerations, as far as the limits allow: w1 three times the
    friction limit f g/mu, w2 0.8 of it, Z three times the bound on friction's moment, mu_1 Z = 3
    R_0 (Chernousko 2020, eq. 28)."""
    threshold, scale = (
        capsule.holding_acceleration,
        TurnManoeuvre(capsule, limits.radius, 1.0, 1e-9),
    )
    return Style(
        min(3.0 * threshold, limits.acceleration),
        min(0.8, limits.holding) * threshold,
        3.0 * scale.friction_bound / scale.inertia_ratio,
        equal=True,
    )
