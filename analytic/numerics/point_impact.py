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
        """The ratio q (module docstring) during the initial slip, and after that slip has ended."""
        a, b, _ = self.weights
        f = self.friction
        after_slip = min(max(-b / a, -f), f)
        if not self.slip:
            return after_slip, after_slip
        return -math.copysign(f, self.slip), after_slip

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
        a, b, c = self.weights
        q_in_slip, q_after = self.ratios
        v = self.speed
        slip_rate = b + a * q_in_slip
        rate = c + b * q_in_slip
        rate_after = c + b * q_after
        slip_end = 0.0  # normal impulse at which slip ends
        if self.slip:
            slip_end = -self.slip / slip_rate if self.slip * slip_rate < 0.0 else math.inf
        v_at_end = v + rate * slip_end

        def impulse_at(speed: float) -> float:
            """Returns the normal impulse [N s] at which the normal velocity is `speed` [m/s]."""
            if speed > v_at_end:
                return slip_end + (speed - v_at_end) / rate_after
            return (speed - v) / rate

        if self.law == "newton":
            total = impulse_at(-self.restitution * v)
        elif self.law == "poisson":
            total = (1.0 + self.restitution) * impulse_at(0.0)
        else:
            slip_compression = min(impulse_at(0.0), slip_end)
            twice_work = -(v + min(v_at_end, 0.0)) * slip_compression
            total = impulse_at(self._rebound(twice_work, v_at_end, rate, rate_after))
        in_slip = min(total, slip_end)
        return slip_end, total, q_in_slip * in_slip + q_after * (total - in_slip)

    def _rebound(
        self, twice_work: float, v_at_end: float, rate: float, rate_after: float
    ) -> float:
        """Returns the velocity off the floor [m/s] after which e^2 of the work of compression is
        returned.

        `twice_work` is twice the work of compression before slip ends, `v_at_end` the velocity v
        when slip ends. `rate` and `rate_after` are dv/dP before and after the end of slip. Work is
        the impulse times the mean velocity.
        """
        negative = min(v_at_end, 0.0)
        positive = max(v_at_end, 0.0)
        returned = self.restitution**2 * (twice_work + negative**2 / rate_after)
        returned_in_slip = positive**2 / rate if positive else 0.0
        if returned > returned_in_slip:
            return math.sqrt(positive**2 + rate_after * (returned - returned_in_slip))
        return math.sqrt(rate * returned)

    @property
    def outcome(self) -> str:
        """Result of the impact: "slides", "sticks" or "reverses"."""
        slip, total, _ = self.impulses
        if total > slip and -self.weights[1] / self.weights[0] == self.ratios[1]:
            return "sticks"
        return "reverses" if total > slip > 0.0 else "slides"
