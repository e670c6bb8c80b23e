"""The largest step at which no mode of a linear system grows that the exact flow lets be."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from plumbob.analytic.bisection import bisected
from plumbob.analytic.errors.smooth_motion.scheme_steps import Advance, Parts
from plumbob.analytic.numerics.smooth.smooth_system import TINY
from plumbob.analytic.reference import Array
from plumbob.analytic.stability import LARGEST, LOST_GROWTH, SMALLEST

LEAST_STEPS = 10_000  # that a step must hold for
LEAST_PERIODS = 100  # of the fastest mode
# Chosen: a mode that grows in the exact motion may grow this much faster in a step. A step's own
# error of a growing mode is accuracy's business; one that blows up exceeds any such factor.
FASTER = 1.5
QUIET = 1e-3  # of a swing: what is smaller has come to rest
RANGE = (math.tau * SMALLEST, math.tau * LARGEST)  # of h |lambda|, the fastest mode's
# step sizes a factor of 1.02 apart: a window of instability that is narrower is missed
GRID = 600
Marks = npt.NDArray[np.bool_]
Complex = npt.NDArray[np.complex128]
Matrices = Callable[[Array], Array | Complex]
"""Step sizes [s], shape (n,) -> matrices of a step, shape (n, m, m)."""


def jacobians(advance: Advance, state: Parts, count: int) -> Array:
    """The derivative of a step of `count` sizes at once, at a state of d numbers or arrays of shape
    (count,), by imaginary parts: shape (count, d, d)."""
    columns = []
    for varied in range(len(state)):
        nudges = (TINY * 1j * (varied == i) for i in range(len(state)))
        nudged = [np.zeros(count) + x + nudge for x, nudge in zip(state, nudges, strict=True)]
        after = [np.imag(part) / TINY for part in advance(0.0, nudged)]
        columns.append(np.stack(after, axis=-1))
    return np.stack(columns, axis=-1)


def run_length(steps: Array, fastest: float) -> npt.NDArray[np.int64]:
    """Number of steps that each of `steps` [s] must hold for, with the shortest period [s]."""
    periods = np.ceil(LEAST_PERIODS * fastest / steps)
    return np.maximum(LEAST_STEPS, periods.astype(np.int64))


def excess(matrices: Matrices, rates: Complex, steps: Array) -> Array:
    """How much faster than the flow's a mode of the step grows, at most, in the logarithm of its
    multiplier, at `steps` [s], shape (n,); modes are matched by their growth (eq. 13.3)."""
    with np.errstate(divide="ignore"):
        grown = np.log(np.abs(np.linalg.eigvals(matrices(steps))))
    flow = np.full(grown.shape[1], -np.inf)  # modes that the scheme alone has
    flow[: len(rates)] = np.sort(rates.real)[::-1]
    allowed = np.maximum(0.0, FASTER * steps[:, None] * flow)
    return np.asarray((-np.sort(-grown, axis=1) - allowed).max(axis=1))


def largest_step(
    matrices: Matrices, rates: Complex, rate: float | None = None, factor: float = LOST_GROWTH
) -> float:
    """The step [s] below which every smaller one holds: no mode exceeds the flow's by `factor`
    within a run's length. Infinite where none up to RANGE's end fails, or nothing moves. The
    fastest `rate` [1/s] is that of the modes, unless something else moves with them."""
    rate = float(np.abs(rates).max()) if rate is None else rate

    def fails(steps: Array) -> Marks:
        counts = run_length(steps, math.tau / rate)
        return counts * excess(matrices, rates, steps) > math.log(factor)

    return first_failing(fails, rate)


def largest_lasting_step(matrices: Matrices, rates: Complex) -> float:
    """The step [s] below which no smaller one brings an undamped swing to rest, that is to QUIET of
    its size, within three quarters of a run's length."""
    rate = float(np.abs(rates).max())

    def fails(steps: Array) -> Marks:
        radius = np.abs(np.linalg.eigvals(matrices(steps))).max(axis=1)
        counts = run_length(steps, math.tau / rate)
        return np.asarray(0.75 * counts * np.log(radius) < math.log(QUIET))

    return first_failing(fails, rate)


def first_failing(fails: Callable[[Array], Marks], rate: float) -> float:
    """The step [s] below which none fails, of RANGE by the fastest `rate` [1/s]; infinite where
    none does."""
    if not rate:
        return math.inf
    steps = np.geomspace(*RANGE, GRID) / rate
    failing = np.flatnonzero(fails(steps))
    if not failing.size:
        return math.inf
    held, failed = map(float, steps[[max(failing[0] - 1, 0), failing[0]]])

    def middle(held: float, failed: float) -> float | None:
        return math.sqrt(held * failed) if failed / held - 1.0 > 1e-12 else None

    return bisected(lambda step: not fails(np.array([step]))[0], held, failed, middle)[0]
