"""Table of one period of a motion, for fast evaluation at many times.

The table has a Taylor series at each of many nodes. A time is reduced to one period by 34 digits of
the period; then a polynomial of degree 7 is evaluated.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.numerics.elliptic.motion import EllipticMotion
from plumbob.analytic.numerics.power_series import constant, flow_series
from plumbob.analytic.numerics.quad import Quad, double
from plumbob.analytic.reference import Array

_BLOCK_SIZE = 32768  # times evaluated together, so that they stay in the cache
_DEGREE = 7  # degree of the Taylor series
# Nodes in a time constant of the motion. With 8 of them the error of a rate is 7e-13, with 12 it is
# 4e-14; 24 leave a margin.
_NODES_PER_TIME_CONSTANT = 24.0
_MAX_NODES = 2**14  # largest number of nodes, which take 0.07 s


@dataclass(frozen=True)
class OrbitTable:
    """Taylor series of theta [rad] at evenly spaced times of one period, both ends included."""

    period: Quad  # [s]
    # Taylor coefficients at each node, shape (8, nodes), the constant first; time in node spacings
    series: Array

    @property
    def turn(self) -> float:
        """Angle [rad] by which theta grows in a period, a multiple of 2 pi."""
        growth = self.series[0, -1] - self.series[0, 0]
        return float(2 * np.pi * np.rint(growth / (2 * np.pi)))

    def state(self, times: Array) -> tuple[Array, Array]:
        """Returns theta [rad] and theta_dot [rad/s] at `times` [s], shape (n,)."""
        theta, rate = np.empty((2, times.size))
        for start in range(0, times.size, _BLOCK_SIZE):
            part = slice(start, start + _BLOCK_SIZE)
            theta[part], rate[part] = self._state(times[part])
        return theta, rate

    def _state(self, times: Array) -> tuple[Array, Array]:
        """Returns theta and theta_dot at one block of times; see `state`."""
        period = double(self.period)
        node_rate = (self.series.shape[1] - 1) / period
        turns = np.floor(times / period)
        # The period is subtracted in three parts, so that only the last product is rounded.
        high = _leading_bits(period)
        low = _leading_bits(double(self.period - high))
        offset = times - turns * high
        offset -= turns * low
        offset -= turns * double(self.period - high - low)
        offset *= node_rate
        nearest = np.rint(offset)
        offset -= nearest
        node = nearest.astype(np.intp)
        theta = self.series[-1].take(node, mode="clip")
        slope = np.zeros_like(offset)
        for terms in self.series[-2::-1]:
            slope *= offset
            slope += theta
            theta *= offset
            theta += terms.take(node, mode="clip")
        return theta + turns * self.turn, slope * node_rate


def _leading_bits(value: float) -> float:
    """Returns the first 20 bits of a number, so that its products with up to 2^33 turns are
    exact."""
    large = (2.0**33 + 1.0) * value
    return large - (large - value)


def orbit_table(
    motion: EllipticMotion, acceleration: Callable[..., Any], fastest: float
) -> OrbitTable | None:
    """Returns the table of one period of a `motion`; None if the period needs too many nodes.

    `acceleration` is a function of time, theta and theta_dot [rad/s^2]. `fastest` is the fastest
    rate of the motion [1/s].
    """
    period = double(motion.period)
    count = np.ceil(_NODES_PER_TIME_CONSTANT * fastest * period)
    if not count <= _MAX_NODES:
        return None
    times = np.linspace(0.0, period, int(count) + 1)
    start = [constant(part, _DEGREE) for part in motion.state(times)]
    series, _ = flow_series(lambda h, z: (z[1], acceleration(h, *z)), start)
    powers = times[1] ** np.arange(_DEGREE + 1.0)
    terms = np.array(np.broadcast_arrays(*series.terms))  # without forces, zeros are numbers
    return OrbitTable(motion.period, terms * powers[:, None])
