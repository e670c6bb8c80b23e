"""Impact of a point of a body on a rough floor: it slides, sticks, or reverses its slip.

While the normal impulse P grows, the velocity s along and v off the floor of the point change as

    ds/dP = b + a q,  dv/dP = c + b q

with the friction impulse dQ/dP = q: -f sign(s) in slip; where that has ended -b/a, which holds the
point, or the nearest that friction has (Routh 1905, Dynamics of a System of Rigid Bodies, 187-193).
Compression ends where v = 0, and the impact where v is -e times its first value (Newton), P is
1 + e times that of compression (Poisson), or e^2 of the work of compression is given back (Stronge
1990, Proc. R. Soc. Lond. A 431, 169).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from plumbob.analytic.parameters import ParameterError, non_negative, positive

LAWS = ("newton", "poisson", "energetic")


@dataclass(frozen=True)
class PointImpact:
    """Inverse masses a, b and c [1/kg], coefficients of `friction` f and `restitution` e, by a law
    of LAWS, and the velocities before, `slip` s and `speed` v <= 0 [m/s]; raises ParameterError."""

    weights: tuple[float, float, float]
    friction: float
    restitution: float
    law: str
    slip: float
    speed: float

    def __post_init__(self) -> None:
        non_negative("friction", self.friction)
        if positive("restitution", self.restitution) > 1.0:
            raise ParameterError("restitution", self.restitution, "at most 1")
        if self.law not in LAWS:
            raise ParameterError("law", self.law, f"one of {', '.join(LAWS)}")

    @property
    def ratios(self) -> tuple[float, float]:
        """q in the slip of the start, and after it."""
        (a, b, _) = self.weights
        f = self.friction
        after = min(max(-b / a, -f), f)
        return (-math.copysign(f, self.slip) if self.slip else after), after

    @property
    def jams(self) -> bool:
        """Whether forces press the point down while it slides."""
        return self.weights[2] + self.weights[1] * self.ratios[0] < 0.0

    @property
    def impulses(self) -> tuple[float, float, float]:
        """P where slip ends and in all, and the friction impulse Q [N s]; by v and its work, which
        are polynomials of P before and after the end of slip."""
        (a, b, c) = self.weights
        (q, after) = self.ratios
        v = self.speed
        slows = b + a * q
        rate = c + b * q
        later = c + b * after
        ends = -self.slip / slows if self.slip * slows < 0.0 else math.inf
        slip = ends if self.slip else 0.0
        then = v + rate * slip  # v where slip ends

        def reached(speed: float) -> float:
            return slip + (speed - then) / later if speed > then else (speed - v) / rate

        if self.law == "newton":
            total = reached(-self.restitution * v)
        elif self.law == "poisson":
            total = (1.0 + self.restitution) * reached(0.0)
        else:
            pressed = -(v + min(then, 0.0)) * min(reached(0.0), slip)  # twice the work in slip
            total = reached(self._rebound(pressed, then, rate, later))
        slid = min(total, slip)
        return slip, total, q * slid + after * (total - slid)

    def _rebound(self, pressed: float, then: float, rate: float, later: float) -> float:
        """The velocity off the floor [m/s] that gives back e^2 of the work of compression: the
        impulse times the mean velocity, here twice that."""
        low = min(then, 0.0)
        high = max(then, 0.0)
        back = self.restitution**2 * (pressed + low**2 / later)
        first = high**2 / rate if high else 0.0
        return math.sqrt(high**2 + later * (back - first) if back > first else rate * back)

    @property
    def outcome(self) -> str:
        """`slides`, `sticks` or `reverses`."""
        slip, total, _ = self.impulses
        if total > slip and -self.weights[1] / self.weights[0] == self.ratios[1]:
            return "sticks"
        return "reverses" if total > slip > 0.0 else "slides"
