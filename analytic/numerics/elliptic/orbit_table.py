"""One period of a motion as a table, for many times at once: position reduced with 34 digits of the
period, then a polynomial of degree 4.

Hermite's polynomials of degree 7 come first: the equation of motion gives three derivatives at
every node. Each is then cut into pieces on which degree 4 is as good, and cheaper to evaluate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import comb

import numpy as np
import numpy.typing as npt

from plumbob.analytic.numerics.elliptic.motion import TURN, EllipticMotion
from plumbob.analytic.numerics.quad import double, split
from plumbob.analytic.reference import Array

_BLOCK = 16384  # times handled together, so that they stay in the cache
_PIECES = 16  # of an interval between two nodes
_DEGREE = 4
_NODES = 15.0  # per time in which the motion changes: what degree 7 needs for 16 digits, or nearly
_MOST = 2**14  # nodes


@dataclass(frozen=True)
class OrbitTable:
    """Piecewise polynomials of theta and theta_dot over one period, from the start on."""

    period: tuple[float, float]  # [s], two parts that add up to 34 digits
    turn: float  # +-1 rotating, else 0
    theta: Array  # shape (5, n): coefficients in the fraction of a piece, constant first
    theta_dot: Array

    def state(self, times: Array) -> tuple[Array, Array]:
        """theta [rad] and theta_dot [rad/s] at `times` [s], shape (m,)."""
        theta, theta_dot = self._evaluate(times, (self.theta, self.theta_dot))
        return theta, theta_dot

    def angle(self, times: Array) -> Array:
        """theta [rad] at `times` [s], shape (m,)."""
        return self._evaluate(times, (self.theta,))[0]

    def _evaluate(self, times: Array, tables: Sequence[Array]) -> list[Array]:
        """Values of the tables; the first one advances by a turn in each period."""
        high, low = self.period
        last = self.theta.shape[1] - 1
        results = [np.empty_like(times) for _ in tables]
        size = min(_BLOCK, times.size)
        turns, offset, term = np.empty((3, size))
        index = np.empty(size, dtype=np.intp)
        for start in range(0, times.size, _BLOCK):
            t = times[start : start + _BLOCK]
            if t.size < size:
                turns, offset, term = turns[: t.size], offset[: t.size], term[: t.size]
                index = index[: t.size]
            np.multiply(t, 1.0 / (high + low), out=turns)
            np.floor(turns, out=turns)
            np.multiply(turns, high, out=offset)
            np.subtract(t, offset, out=offset)
            np.multiply(turns, low, out=term)
            offset -= term
            offset *= (last + 1) / (high + low)
            np.floor(offset, out=term)
            np.clip(term, 0.0, last, out=term)  # round-off may put a time just outside
            offset -= term
            np.copyto(index, term, casting="unsafe")
            for table, result in zip(tables, results, strict=True):
                _horner(table, index, offset, term, result[start : start + _BLOCK])
            for part in reversed(TURN) if self.turn else ():
                np.multiply(turns, self.turn * part, out=term)
                results[0][start : start + _BLOCK] += term
        return results


def _horner(
    table: Array, index: npt.NDArray[np.intp], offset: Array, term: Array, value: Array
) -> None:
    """Write the polynomials of the intervals `index` at `offset` into `value`; `term` is used."""
    table[_DEGREE].take(index, out=value, mode="clip")
    for row in table[_DEGREE - 1 :: -1]:
        value *= offset
        row.take(index, out=term, mode="clip")
        value += term


def orbit_table(motion: EllipticMotion) -> OrbitTable:
    """Tabulate one period of a single motion of finite period, as finely as round-off allows."""
    period, force = double(motion.period), _Force.of(motion)
    rate_scale = force.rate + _fastest(motion)
    count = int(np.ceil(_NODES * period * rate_scale))
    while True:
        count = min(count, _MOST)
        theta, rate = motion.state(np.linspace(0.0, period, count + 1))
        pieces, error = _hermite(force.derivatives(theta, rate), period / count)
        # Errors relative to 1 rad and to the rate that turns 1 rad.
        if max(error[0], error[1] / rate_scale) <= 5e-16 or count == _MOST:
            break
        count *= 2
    turn = round((theta[-1] - theta[0]) / (2 * np.pi))
    high, low = split(motion.period, 20)
    return OrbitTable((float(high), float(low)), float(turn), pieces[0], pieces[1])


def _fastest(motion: EllipticMotion) -> float:
    """Bound on |theta_dot| [rad/s]."""
    v = motion.potential
    most = double(motion.kinetic + v.value(motion.theta0)) + v.scale
    return float(np.sqrt(2 * max(most, 0.0) / double(motion.inertia)))


@dataclass(frozen=True)
class _Force:
    """The equation of motion theta'' = a sin 2theta + b cos theta - c sin theta [1/s^2]."""

    a: float
    b: float
    c: float

    @classmethod
    def of(cls, motion: EllipticMotion) -> _Force:
        v, inertia = motion.potential, double(motion.inertia)
        return cls(double(v.a) / inertia, double(v.b) / inertia, double(v.c) / inertia)

    @property
    def rate(self) -> float:
        """Bound on the rate of small oscillations [1/s]."""
        return float(np.sqrt(2 * abs(self.a) + abs(self.b) + abs(self.c)))

    def derivatives(self, theta: Array, rate: Array) -> Array:
        """theta and its first four derivatives by time, shape (5, n), at states of shape (n,)."""
        a, b, c = self.a, self.b, self.c
        sine, cosine = np.sin(theta), np.cos(theta)
        twice, curve = (2 * a) * sine + b, (2 * a) * cosine
        second = twice * cosine - c * sine
        slope = (curve - c) * cosine - twice * sine
        bend = (c * sine - (b + (8 * a) * sine) * cosine) * rate**2
        return np.array([theta, rate, second, slope * rate, bend + slope * second])


def _hermite(derivatives: Array, width: float) -> tuple[Array, Array]:
    """Coefficients, shape (2, 5, 16 n), on the pieces of intervals of a function and its
    derivative, given with three more at n + 1 nodes `width` apart; and the errors of degree 7."""
    scaled = np.stack([derivatives[:4], derivatives[1:]])
    scaled *= (width**_POWERS / _FACTORIALS)[:, None]
    left = scaled[..., :-1]
    gap = scaled[..., 1:] - _BINOMIAL @ left  # first, as differences, before they are multiplied
    known = np.concatenate([left[:, 1:], gap], axis=1).transpose(0, 2, 1)
    pieces = known[:, None] @ _cut()
    pieces[:, 0] += left[:, 0, :, None]
    error = np.abs(np.diff(_UPPER[3] @ gap)).max(axis=-1, initial=0.0) / 2**11
    return pieces.reshape(2, _DEGREE + 1, -1), error


_POWERS = np.arange(4.0)
_FACTORIALS = np.array([1.0, 1.0, 2.0, 6.0])
_BINOMIAL = np.array([[1, 1, 1, 1.0], [0, 1, 2, 3], [0, 0, 1, 3], [0, 0, 0, 1]])
_UPPER = np.array([[35, -15, 5, -1.0], [-84, 39, -14, 3], [70, -34, 13, -3], [-20, 10, -4, 1]])


@cache
def _cut() -> Array:
    """Matrix from three coefficients of Hermite's polynomial and four gaps to the coefficients of
    degree 4 on each piece, shape (5, 7, 16): shifted, scaled, and the powers 5 to 7 replaced by
    their interpolants at Chebyshev's points."""
    powers = np.arange(8)
    choose = np.array([[comb(k, i) for k in powers] for i in powers], dtype=float)
    starts = np.arange(_PIECES)[:, None, None] / _PIECES
    shift = choose * starts ** np.maximum(powers - powers[:, None], 0)
    shift = shift / float(_PIECES) ** powers[:, None]
    points = 0.5 - 0.5 * np.cos(np.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1))
    table = points[:, None] ** powers
    economy = np.linalg.solve(table[:, : _DEGREE + 1], table)
    full = economy @ shift
    cut = np.concatenate([full[..., 1:4], full[..., 4:] @ _UPPER], axis=-1)
    return np.ascontiguousarray(cut.transpose(1, 2, 0))
