"""Impact of a point of a body on a rough floor: it slides, sticks, or reverses its slip.

The point has the velocity s along the floor and v normal to it. While the normal impulse P grows,
they change as

    ds/dP = b + a q,  dv/dP = c + b q

where q = dQ/dP and Q is the friction impulse. During slip, q is -f sign(s). After slip has ended, q
is -b/a, which holds the point; if that exceeds friction, q is the nearest value within -f and f
(Routh 1905, Dynamics of a System of Rigid Bodies, 187-193). Compression ends at v = 0. The impact
ends when v is -e times its first value (Newton), when P is 1 + e times the impulse of compression
(Poisson), or when e^2 of the work of compression is returned (Stronge 1990, Proc. R. Soc. Lond. A
431, 169).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from plumbob.analytic.parameters import ParameterError, non_negative, positive

LAWS = ("newton", "poisson", "energetic")


@dataclass(frozen=True)
class PointImpact:
    """The impact of a point on a floor. Raises ParameterError for values outside their range."""

    weights: tuple[float, float, float]  # [1/kg] inverse masses a, b and c
    friction: float  # coefficient of friction f
    restitution: float  # coefficient of restitution e
    law: str  # meaning of the restitution: one of LAWS
    slip: float  # [m/s] velocity s along the floor before the impact
    speed: float  # [m/s] velocity v <= 0 normal to the floor before the impact

    def __post_init__(self) -> None:
        non_negative("friction", self.friction)
        if positive("restitution", self.restitution) > 1.0:
            raise ParameterError("restitution", self.restitution, "at most 1")
        if self.law not in LAWS:
            raise ParameterError("law", self.law, f"one of {', '.join(LAWS)}")

    @property
    def ratios(self) -> tuple[float, float]:
        """q during the initial slip, and q after that slip has ended."""
        (a, b, _) = self.weights
        f = self.friction
        after = min(max(-b / a, -f), f)
        return (-math.copysign(f, self.slip) if self.slip else after), after

    @property
    def jams(self) -> bool:
        """Whether the contact forces accelerate the point downwards while it slides."""
        return self.weights[2] + self.weights[1] * self.ratios[0] < 0.0

    @property
    def impulses(self) -> tuple[float, float, float]:
        """The normal impulse at the end of slip, the whole normal impulse, and the friction impulse
        [N s].

        Before and after the end of slip, v is a linear and its work a quadratic function of P.
        """
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
        """Returns the velocity off the floor [m/s] after which e^2 of the work of compression is
        returned.

        `pressed` is the work done before slip ends, `then` the velocity v when slip ends, `rate`
        and `later` are dv/dP before and after the end of slip. Work is the impulse times the mean
        velocity; all values here are twice the work.
        """
        low = min(then, 0.0)
        high = max(then, 0.0)
        back = self.restitution**2 * (pressed + low**2 / later)
        first = high**2 / rate if high else 0.0
        return math.sqrt(high**2 + later * (back - first) if back > first else rate * back)

    @property
    def outcome(self) -> str:
        """Result of the impact: "slides", "sticks" or "reverses"."""
        slip, total, _ = self.impulses
        if total > slip and -self.weights[1] / self.weights[0] == self.ratios[1]:
            return "sticks"
        return "reverses" if total > slip > 0.0 else "slides"
