"""The pendulum's period, action and time of an angle by quadrature with 40 digits: a witness that
shares neither formula nor arithmetic with the closed form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mpmath as mp

DIGITS = 40


@dataclass(frozen=True)
class Orbit:
    """I theta'^2 / 2 + V(theta) = H with V = -a sin^2 - b sin - c cos, all mpmath numbers."""

    a: mp.mpf
    b: mp.mpf
    c: mp.mpf
    inertia: mp.mpf
    theta: mp.mpf
    theta_dot: mp.mpf

    def fall(self, theta: mp.mpf) -> mp.mpf:
        """H - V(theta), without the difference of nearly equal numbers."""
        d, m = (theta - self.theta) / 2, (theta + self.theta) / 2
        drop = self.a * mp.sin(2 * m) * mp.sin(2 * d) + 2 * mp.sin(d) * (
            self.b * mp.cos(m) - self.c * mp.sin(m)
        )
        return self.inertia * self.theta_dot**2 / 2 + drop

    def speed(self, theta: mp.mpf) -> mp.mpf:
        """|theta'| at an angle that the motion reaches."""
        return mp.sqrt(2 * abs(self.fall(theta)) / self.inertia)

    def slope(self, theta: mp.mpf) -> mp.mpf:
        """dV/dtheta."""
        return -self.a * mp.sin(2 * theta) - self.b * mp.cos(theta) + self.c * mp.sin(theta)

    def turning_points(self, samples: int = 2000) -> tuple[mp.mpf, mp.mpf] | None:
        """The nearest zeros of H - V on either side of the start, or None when it rotates."""
        found = []
        for sense in (-1, 1):
            edge = self._edge(sense, samples)
            if edge is None:
                return None
            found.append(edge)
        return found[0], found[1]

    def _edge(self, sense: int, samples: int) -> mp.mpf | None:
        if self.theta_dot == 0 and sense * self.slope(self.theta) > 0:
            return self.theta
        step = 2 * mp.pi / samples * sense
        for i in range(1, samples + 1):
            if self.fall(self.theta + i * step) < 0:
                low, high = self.theta + (i - 1) * step, self.theta + i * step
                if i == 1:
                    low = self.theta + step * mp.mpf(10) ** -12
                return mp.findroot(self.fall, (low, high), solver="anderson", tol=1e-70)
        return None

    def period_and_action(self) -> tuple[mp.mpf, mp.mpf]:
        """Period and (1/2 pi) closed integral of p dtheta, by the trapezoid rule, which converges
        geometrically: in theta over a turn, and between turning points in s, where
        theta = middle + reach sin s takes the square roots away."""
        turning = self.turning_points()
        if turning is None:
            return self._trapezoid(lambda x: (self.theta + x, mp.mpf(1)))
        middle, reach = (turning[1] + turning[0]) / 2, (turning[1] - turning[0]) / 2
        # Half-shifted points keep clear of the turning points, where 0/0 would lose digits.
        return self._trapezoid(lambda s: (middle + reach * mp.sin(s), abs(reach * mp.cos(s))))

    def _trapezoid(self, chart: Callable[[mp.mpf], tuple[mp.mpf, mp.mpf]]) -> tuple[mp.mpf, mp.mpf]:
        last = (mp.mpf(0), mp.mpf(0))
        for k in range(5, 16):
            count = 2**k
            points = [chart(2 * mp.pi * (i + mp.mpf(1) / 2) / count) for i in range(count)]
            speeds = [(self.speed(theta), width) for theta, width in points]
            time = sum(w / v for v, w in speeds) * 2 * mp.pi / count
            action = self.inertia * sum(w * v for v, w in speeds) / count
            if abs(time / last[0] - 1 if last[0] else 1) < 1e-17:
                return time, action
            last = time, action
        raise ArithmeticError("the trapezoid rule has not converged")

    def time_between(self, low: mp.mpf, high: mp.mpf) -> mp.mpf:
        """Time from one angle to another that the motion passes without turning."""
        return mp.quad(lambda x: 1 / self.speed(x), mp.linspace(low, high, 4))
