"""A rod that strikes a rough floor at an angle: Routh's impact, in which it slides, sticks or
reverses its slip.

While the normal impulse P grows, the velocity s along and v off the floor of the lower end of a
uniform rod at an angle t from the floor, which points forward where t > pi/2, change as

    ds/dP = b + a q,  dv/dP = c + b q,  m (a, b, c) = 1 + 3 sin^2 t, -3 sin t cos t, 1 + 3 cos^2 t

with the friction impulse dQ/dP = q: -f sign(s) in slip; where that has ended -b/a, which holds the
end, or the nearest that friction has (Routh 1905, Dynamics of a System of Rigid Bodies, 187-193).
Compression ends where v = 0, and the impact where v is -e times its first value (Newton), P is
1 + e times that of compression (Poisson), or e^2 of the work of compression is given back (Stronge
1990, Proc. R. Soc. Lond. A 431, 169). Where c + b q < 0 forces press the sliding end down, and a
rod that slides without falling has an impact (Genot and Brogliato 1999, Eur. J. Mech. A 18, 653).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP, rounded_inputs
from plumbob.analytic.parameters import ParameterError, finite, non_negative, positive
from plumbob.analytic.reference import Array, LinearResponse

LAWS = ("newton", "poisson", "energetic")
ROUNDINGS = 16.0  # of each parameter
INSTANTS = 2001  # at which the ends are looked at after the impact


@dataclass(frozen=True)
class RodImpact(LinearResponse):
    """A rod of `length` [m] and `mass` [kg] at an `angle` [rad] from the floor falls from where its
    lower end is at a `height` [m], under `gravity` [m/s^2], with a `speed` [m/s] along the floor,
    and strikes it with a coefficient of `friction`, and of `restitution` by a `law` of LAWS; raises
    ParameterError.

    >>> RodImpact(1.0, 1.0, 1.1, 0.5, -2.0, 0.3, 0.5, "newton", 9.81).outcome
    'slides'
    """

    length: float
    mass: float
    angle: float
    height: float
    speed: float
    friction: float
    restitution: float
    law: str
    gravity: float

    def __post_init__(self) -> None:
        for name in ("length", "mass", "angle", "restitution", "gravity"):
            positive(name, getattr(self, name))
        finite("speed", self.speed)
        non_negative("friction", self.friction)
        for name, most in (("angle", 3.1415), ("restitution", 1.0)):
            if (value := getattr(self, name)) > most:
                raise ParameterError(name, value, f"at most {most:g}")
        if self.law not in LAWS:
            raise ParameterError("law", self.law, f"one of {', '.join(LAWS)}")
        strikes = self.jams and self.law != LAWS[0]  # which gives nothing back to what never fell
        if not (non_negative("height", self.height) or strikes):
            raise ParameterError("height", self.height, "greater than 0, or there is no rebound")

    @property
    def weights(self) -> tuple[float, float, float]:
        """a, b and c [1/kg]."""
        sine, cosine, light = math.sin(self.angle), math.cos(self.angle), 1.0 / self.mass
        return light * (1 + 3 * sine**2), -3 * light * sine * cosine, light * (1 + 3 * cosine**2)

    @property
    def ratios(self) -> tuple[float, float]:
        """q in the slip of the start, and after it."""
        (a, b, _), f = self.weights, self.friction
        after = min(max(-b / a, -f), f)
        return (-math.copysign(f, self.speed) if self.speed else after), after

    @property
    def jams(self) -> bool:
        """Whether forces press its sliding end down: Painleve's rod, its lower end ahead, with f of
        more than (1 + 3 cos^2 t)/|3 sin t cos t|, 4/3 or more."""
        return self.weights[2] + self.weights[1] * self.ratios[0] < 0.0

    @property
    def fall(self) -> float:
        """Time of the impact [s]."""
        return math.sqrt(2.0 * self.height / self.gravity)

    @cached_property
    def impulses(self) -> tuple[float, float, float]:
        """P where slip ends and in all, and the friction impulse Q [N s]; by v and its work, which
        are polynomials of P before and after the end of slip."""
        (a, b, c), (q, after) = self.weights, self.ratios
        slows, v, rate, later = b + a * q, -self.gravity * self.fall, c + b * q, c + b * after
        ends = -self.speed / slows if self.speed * slows < 0.0 else math.inf
        slip = ends if self.speed else 0.0
        then = v + rate * slip  # v where slip ends

        def reached(speed: float) -> float:
            return slip + (speed - then) / later if speed > then else (speed - v) / rate

        if self.law == "newton":
            total = reached(-self.restitution * v)
        elif self.law == "poisson":
            total = (1.0 + self.restitution) * reached(0.0)
        else:
            pressed = -(v + min(then, 0.0)) * min(reached(0.0), slip)  # twice the work in slip
            total = reached(_rebound(self.restitution, pressed, then, rate, later))
        slid = min(total, slip)
        return slip, total, q * slid + after * (total - slid)

    @property
    def outcome(self) -> str:
        """`slides`, `sticks` or `reverses`."""
        slip, total, _ = self.impulses
        if total > slip and -self.weights[1] / self.weights[0] == self.ratios[1]:
            return "sticks"
        return "reverses" if total > slip > 0.0 else "slides"

    def _flown(self, times: Array) -> Mapping[str, Array]:
        _, up, along = self.impulses
        sine, cosine, g = math.sin(self.angle), math.cos(self.angle), self.gravity
        since = np.maximum(times - self.fall, 0.0)
        turned = 6.0 * (along * sine - up * cosine) / self.length
        return {
            "x": self.speed * times + along / self.mass * since,
            "z": self.height
            + self.length / 2.0 * sine
            - g * times**2 / 2.0
            + up / self.mass * since,
            "angle": self.angle + turned / self.mass * since,
        }

    @cached_property
    def until(self) -> float:
        """A time [s] shortly before an end strikes for a second time."""
        late = self.fall + self.impulses[1] / self.mass / self.gravity
        most = 2.0 * late + math.sqrt(
            8.0 * self.length / self.gravity
        )  # by then it is in the floor
        times = np.linspace(self.fall, most, INSTANTS)
        flown = self._flown(times)
        above = flown["z"] > self.length / 2.0 * np.abs(np.sin(flown["angle"]))
        return float(times[int(np.argmin(above[1:]))])

    def observe(self, times: Array) -> Mapping[str, Array]:
        """Place of the centre x and z [m] and the angle [rad] at `times` [s], shape (n,); raises
        ParameterError beyond `until`."""
        if (last := float(np.max(times, initial=0.0))) > self.until:
            raise ParameterError("times", last, f"at most {self.until:.6g} s: it strikes again")
        return self._flown(times)

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """Absolute errors, shape (n,), by the effect of each parameter's rounding."""
        doubts = rounded_inputs(self, lambda rod: rod._flown(times), ROUNDINGS)
        moved = ULP * (self.length + abs(self.speed) * times)
        return {name: doubt + moved for name, doubt in doubts.items()}


def _rebound(e: float, pressed: float, then: float, rate: float, later: float) -> float:
    """The velocity off the floor [m/s] that gives back e^2 of the work of compression: the impulse
    times the mean velocity, here twice that."""
    low, high = min(then, 0.0), max(then, 0.0)
    back, first = e**2 * (pressed + low**2 / later), high**2 / rate if high else 0.0
    return math.sqrt(high**2 + later * (back - first) if back > first else rate * back)
