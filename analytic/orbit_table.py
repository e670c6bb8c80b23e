"""One period of a motion as a table, for many times at once: position reduced with 34 digits of the
period, then a polynomial of degree 7.

The polynomials are Hermite's: the equation of motion gives three derivatives at every node.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analytic.elliptic_motion import EllipticMotion
from analytic.quad import double, split
from analytic.reference import Array

_BLOCK = 8192  # times handled together, so that the work stays in the cache


@dataclass(frozen=True)
class OrbitTable:
    """Piecewise polynomials of theta and theta_dot over one period, from the start on."""

    period: tuple[Array, ...]  # [s], three parts that add up to 34 digits
    advance: float  # change of theta in a period: +-2 pi rotating, else 0
    theta: Array  # shape (8, n): coefficients in the fraction of an interval, constant first
    theta_dot: Array

    def state(self, times: Array) -> tuple[Array, Array]:
        """theta [rad] and theta_dot [rad/s] at `times` [s], shape (m,)."""
        return self._evaluate(times, self.theta, self.advance), self._evaluate(
            times, self.theta_dot, 0.0
        )

    def angle(self, times: Array) -> Array:
        """theta [rad] at `times` [s], shape (m,)."""
        return self._evaluate(times, self.theta, self.advance)

    def _evaluate(self, times: Array, table: Array, advance: float) -> Array:
        """The table's value, with `advance` for each whole period."""
        high, middle, low = (float(p) for p in self.period)
        intervals = table.shape[1]
        period = high + middle + low
        per_second = intervals / period
        # 201/32 times a number of turns is exact, and so is the sum with what it leaves of 2 pi.
        coarse = np.copysign(201 / 32, advance) if advance else 0.0
        fine = np.copysign(2 * np.pi - 201 / 32, advance) if advance else 0.0
        result = np.empty_like(times)
        for start in range(0, times.size, _BLOCK):
            t = times[start : start + _BLOCK]
            turns = np.floor(t / period)
            rest = t - turns * high
            rest -= turns * middle
            rest -= turns * low
            rest *= per_second
            node = rest.astype(np.intp)  # a time that rounding put outside uses the nearest piece
            np.clip(node, 0, intervals - 1, out=node)
            rest -= node
            value = table[7].take(node)
            for row in table[6::-1]:
                value *= rest
                value += row.take(node)
            if advance:
                value += turns * fine
                value += turns * coarse
            result[start : start + _BLOCK] = value
        return result


def orbit_table(motion: EllipticMotion, error: float = 1e-15) -> OrbitTable:
    """Tabulate one period of a single motion of finite period, so finely that the polynomials
    meet the closed form midway between the nodes to `error` of the largest value."""
    period = double(motion.period)
    inertia = double(motion.inertia)
    a, b, c = (double(v) for v in (motion.potential.a, motion.potential.b, motion.potential.c))
    count = 128
    while True:
        nodes = np.linspace(0.0, float(period), 2 * count + 1)
        theta, rate = motion.state(nodes, reduced=True)
        sine, cosine = np.sin(theta), np.cos(theta)
        sine2, cosine2 = 2 * sine * cosine, cosine * cosine - sine * sine
        first = (a * sine2 + b * cosine - c * sine) / inertia
        slope = (2 * a * cosine2 - b * sine - c * cosine) / inertia
        bend = (-4 * a * sine2 - b * cosine + c * sine) / inertia
        second = slope * rate
        third = bend * rate**2 + slope * first
        width = float(period) / count
        tables = [
            _hermite(np.stack(values), width)
            for values in ((theta, rate, first, second), (rate, first, second, third))
        ]
        halves = 0.5 ** np.arange(8)
        errors = [
            np.abs(halves @ table - exact[1::2]).max() / np.abs(exact).max()
            for table, exact in zip(tables, (theta, rate), strict=True)
        ]
        if max(errors) <= error or count >= 65536:
            break
        count *= 2
    advance = float(np.round((theta[-1] - theta[0]) / (2 * np.pi))) * 2 * np.pi
    return OrbitTable(tuple(split(motion.period, 20, 3)), advance, *tables)


def _hermite(values: Array, width: float) -> Array:
    """Coefficients, shape (8, n), of the polynomials of degree 7 through the even columns of
    `values`, shape (4, 2 n + 1): a function and three derivatives at nodes `width` apart."""
    scaled = values[:, ::2] * (width ** np.arange(4) / np.array([1.0, 1.0, 2.0, 6.0]))[:, None]
    left, right = scaled[:, :-1], scaled[:, 1:]
    binomial = np.array([[1, 1, 1, 1], [0, 1, 2, 3], [0, 0, 1, 3], [0, 0, 0, 1]])
    gap = right - binomial @ left
    upper = np.array([[35, -15, 5, -1], [-84, 39, -14, 3], [70, -34, 13, -3], [-20, 10, -4, 1]])
    return np.concatenate([left, upper @ gap])
