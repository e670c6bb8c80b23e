"""Rotations of a rigid body without torques, to 34 digits: Euler's equations by Taylor series.

With moments of inertia I in the body's axes, angular velocity w there, and the attitude q,

    I1 dw1/dt = (I2 - I3) w2 w3, and so on in turn,    dq/dt = q (0, w) / 2,

so that each coefficient of a series follows from those before it. All numbers are integers: so many
times 2^-160."""

from itertools import pairwise
from operator import mul

import numpy as np

BITS = 160
ORDER = 40  # of the series
STEP = 0.5  # in radians of the fastest rotation: 44 digits, by steps of a fifth and order 44


def fixed(number):
    """A number, exactly, as an integer."""
    top, bottom = float(number).as_integer_ratio()
    return (top << BITS) // bottom


def _product(one, other):
    """The last coefficient of the product of two series."""
    return sum(map(mul, one, reversed(other))) >> BITS


def _ahead(spin, attitude, ratios, step):
    """The rates and the attitude after a step, all as integers."""
    w = [[value] for value in spin]
    q = [[value] for value in attitude]
    for order in range(1, ORDER + 1):
        turning = [
            ratio * _product(w[j], w[k]) >> BITS
            for ratio, j, k in zip(ratios, (1, 2, 0), (2, 0, 1), strict=True)
        ]
        scalar, vector = q[0], q[1:]
        rates = [-sum(map(_product, vector, w))] + [
            _product(scalar, w[i])
            + _product(vector[(i + 1) % 3], w[(i + 2) % 3])
            - _product(vector[(i + 2) % 3], w[(i + 1) % 3])
            for i in range(3)
        ]
        for series, rate in zip(w, turning, strict=True):
            series.append(rate // order)
        for series, rate in zip(q, rates, strict=True):
            series.append(rate // (2 * order))

    def at(series):
        value = 0
        for coefficient in reversed(series):
            value = coefficient + (value * step >> BITS)
        return value

    return list(map(at, w)), list(map(at, q))


def attitudes(moments, spin, times):
    """Quaternions, scalar first, at `times` [s] of a body with `moments` of inertia [kg m^2] that
    begins to turn from [1, 0, 0, 0] with `spin` [rad/s] in its own axes, shape (len(times), 4)."""
    a, b, c = map(fixed, moments)
    ratios = [((b - c) << BITS) // a, ((c - a) << BITS) // b, ((a - b) << BITS) // c]
    w = list(map(fixed, spin))
    q = [1 << BITS, 0, 0, 0]
    quaternions = [q]
    # No rate exceeds that of all the energy about the axis of the least moment.
    fastest = np.sqrt(np.dot(moments, np.square(spin)) / min(moments))
    for start, end in pairwise(times):
        count = int(np.ceil((end - start) * fastest / STEP))
        step = (fixed(end) - fixed(start)) // count
        for _ in range(count):
            w, q = _ahead(w, q, ratios, step)
        quaternions.append(q)
    return np.array([[float(value) / 2.0**BITS for value in q] for q in quaternions])
