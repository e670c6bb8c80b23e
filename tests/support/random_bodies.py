"""Symmetric and nearly symmetric free bodies at random, and their motion with 50 digits.

A symmetric body turns about its axis and, with that, about the angular momentum L, both evenly. Any
other one is followed by Taylor series of Euler's equations and q' = q w/2. Neither has formula or
arithmetic in common with the closed form.
"""

import math
from dataclasses import dataclass

import gmpy2
import numpy as np
from gmpy2 import mpfr

BITS = 150
TERMS = 36  # of a series
TURN = 1.0  # [rad] of a step: 1/36! of a turn about an axis is left out, 3e-42


@dataclass(frozen=True)
class Drawn:
    """Moments of inertia [kg m^2], angular velocity [rad/s], times [s], and the relative difference
    of the two moments across the axis."""

    moments: tuple[float, float, float]
    rates: tuple[float, float, float]
    times: tuple[float, ...]
    apart: float


def drawn(seed):
    """A body whose axis has 10^-6 to 2 times the moment across it and a spin of 10^-20 to 1 of the
    rate of turning; every other one is exactly symmetric, and turns for longer."""
    rng = np.random.default_rng(seed)
    symmetric = seed % 2 == 0
    ratio = 10 ** rng.uniform(-6, 0) if seed % 4 < 2 else rng.uniform(1, 2)
    across = 10 ** rng.uniform(-3, 3)
    apart = 0.0 if symmetric else 10 ** rng.uniform(-16, -3)
    # two moments differ at most by the third
    other = across * (1 + min(apart, ratio / 2))
    along = min(across * ratio, (across + other) * (1 - 1e-15))
    speed = 10 ** rng.uniform(-2, 2)
    direction = rng.uniform(0, 2 * math.pi)
    spin = rng.choice([-1, 1]) * 10 ** rng.uniform(-20, 0)
    order = rng.permutation(3)
    moments = np.array([along, across, other])[order]
    rates = speed * np.array([spin, math.cos(direction), math.sin(direction)])[order]
    angles = 10 ** rng.uniform([-3, -1, 0], [-1, 0, 1.5])
    if symmetric:
        angles = np.append(angles, 10 ** rng.uniform(2, 6))
    return Drawn(
        tuple(moments.tolist()),
        tuple(rates.tolist()),
        tuple((angles / speed).tolist()),
        apart,
    )


def exact(moments, rates, times):
    """Angular velocity and attitude at ascending `times` [s], shape (7, n), as mpfr numbers."""
    with gmpy2.context(gmpy2.get_context(), precision=BITS):
        moments, rates = ([mpfr(value) for value in values] for values in (moments, rates))
        pairs = [k for k in range(3) if moments[k - 2] == moments[k - 1]]
        if pairs:
            return np.array([_about(pairs[0], moments, rates, mpfr(t)) for t in times]).T
        return np.array(_followed(moments, rates, [mpfr(t) for t in times])).T


def _about(axis, moments, rates, time):
    """The state of a body that is symmetric about an axis."""
    across = moments[axis - 1]
    momentum = [i * w for i, w in zip(moments, rates, strict=True)]
    size = gmpy2.sqrt(sum(part * part for part in momentum))
    slow = rates[axis] * (1 - moments[axis] / across)
    sine, cosine = gmpy2.sin_cos(slow * time)
    state = list(rates)
    first, second = rates[axis - 2], rates[axis - 1]
    state[axis - 2] = cosine * first + sine * second
    state[axis - 1] = cosine * second - sine * first
    sine, cosine = gmpy2.sin_cos(size / across * time / 2)
    turn = [cosine, *(sine * part / (size or 1) for part in momentum)]
    sine, cosine = gmpy2.sin_cos(slow * time / 2)
    about = [cosine, *(sine if k == axis else mpfr(0) for k in range(3))]
    return [*state, *_product(turn, about)]


def _product(p, q):
    (a, b, c, d), (w, x, y, z) = p, q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


def _followed(moments, rates, times):
    """The states of any body."""
    x, y, z = moments
    factors = ((y - z) / x, (z - x) / y, (x - y) / z)
    state = [*rates, mpfr(1), mpfr(0), mpfr(0), mpfr(0)]
    # no rate of turning exceeds that of the same energy about the axis of the least moment
    speed = gmpy2.sqrt(sum(w * w for w in rates)) * _spread(moments, rates)
    states = []
    time = mpfr(0)
    for until in times:
        count = int(gmpy2.ceil((until - time) * speed / TURN)) or 1
        step = (until - time) / count
        for _ in range(count):
            state = [_sum(series, step) for series in _series(factors, state)]
        states.append(state)
        time = until
    return states


def _spread(moments, rates):
    """Bound on the factor by which the rate of turning grows: 1 and what the axis may gain."""
    x, y, z = moments
    return 1 + max(abs(y - z) / x, abs(z - x) / y, abs(x - y) / z)


def _sum(series, step):
    total = mpfr(0)
    for term in reversed(series):
        total = total * step + term
    return total


def _series(factors, state):
    """Taylor coefficients of the state from here on."""
    w = [[part] for part in state[:3]]
    q = [[part] for part in state[3:]]
    for n in range(TERMS):
        pairs = [_at(w[k - 2], w[k - 1], n) for k in range(3)]
        (a, b, c, d), (x, y, z) = q, w
        rates = (
            -_at(b, x, n) - _at(c, y, n) - _at(d, z, n),
            _at(a, x, n) + _at(c, z, n) - _at(d, y, n),
            _at(a, y, n) - _at(b, z, n) + _at(d, x, n),
            _at(a, z, n) + _at(b, y, n) - _at(c, x, n),
        )
        for series, factor, pair in zip(w, factors, pairs, strict=True):
            series.append(factor * pair / (n + 1))
        for series, rate in zip(q, rates, strict=True):
            series.append(rate / (2 * (n + 1)))
    return [*w, *q]


def _at(p, q, n):
    """Coefficient n of a product of series."""
    return gmpy2.fsum([a * b for a, b in zip(p[: n + 1], q[n::-1], strict=True)])
