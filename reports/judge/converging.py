"""Does the error of a method that no theory covers go to zero with the step? Its envelope, the
largest error of each octave of steps, has to fall, and what is smooth has to lead to the exact
answer. Rules of judgement, chosen and not derived, are constants here."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.study.measurement import Measurement, rounding, worst
from plumbob.engines.study.order import fit_order
from plumbob.models.scene import Quantity

PER_OCTAVE = 3  # runs: fewer may all be lucky
OCTAVES = 4  # over which the envelope has to fall
SLOWEST = 0.5  # the slope's confidence interval lies above
ROUND_OFFS = 10.0  # an error within so many round-offs has reached the floor
STALLED = 0.7  # two octaves of finer steps that leave this much of an error have not helped
SMOOTH = 0.05  # of the errors fitted: what a series in the step may leave of smooth ones
LEFT = 0.5  # of the smallest error: what a smooth one may extrapolate to


@dataclass(frozen=True)
class Convergence:
    """The verdict of the envelope: `converges`, `not-converging`, or neither, and why."""

    verdict: Literal["converges", "not-converging"] | None
    reason: str


@dataclass(frozen=True)
class _Point:
    """A run: its step [s], its error and its round-off level, relative to the quantity's scale, and
    its error at the end, signed."""

    step: float
    error: float
    floor: float
    end: float


def convergence(runs: Sequence[Measurement], quantities: Sequence[Quantity]) -> Convergence:
    """Judge the runs of a method without theory, coarse to fine, by their relative errors."""
    points = [_point(m, quantities) for m in runs if m.status == "done"]
    octaves = _octaves([p for p in points if p is not None])
    above = [p for p in octaves if p.error > ROUND_OFFS * p.floor]
    if len(octaves) < OCTAVES:
        return Convergence(None, f"{len(octaves)} octaves of steps, and {OCTAVES} are needed")
    least = f"the smallest error resolved is {min(p.error for p in octaves):.2g}, relative"
    if len(above) < len(octaves) and not above:
        return Convergence("converges", f"within {ROUND_OFFS:g} round-offs at every step; {least}")
    if octaves[-1] in above and _stalled(octaves):
        times = octaves[-1].error / octaves[-1].floor
        why = f"the relative error stays at {octaves[-1].error:.3g}, "
        return Convergence("not-converging", f"{why}{times:.2g} times the round-off level")
    if len(above) < OCTAVES:
        return Convergence(None, f"{len(above)} octaves above the round-off level; {least}")
    slope = _slope(above)
    if slope is None:
        return Convergence(None, f"the error does not fall as a power of the step; {least}")
    fine = [p for p in points if p is not None and p.error > ROUND_OFFS * p.floor]
    left = _extrapolated(fine[-3 * PER_OCTAVE :], max(1, round(slope[0])))
    if left is not None and left > LEFT * fine[-1].error:
        why = f"the error is smooth in the step, and leads to {left:.2g} and not to zero"
        return Convergence("not-converging", f"{why}; {least}")
    low, high = slope[1:]
    return Convergence("converges", f"of order {slope[0]:.2f} ({low:.2f} to {high:.2f}); {least}")


def _point(run: Measurement, quantities: Sequence[Quantity]) -> _Point | None:
    quantity, relative = worst(run, quantities)
    if math.isnan(relative):
        return None
    error = run.errors[quantity.observable]
    return _Point(
        run.step,
        relative,
        rounding(error, run.steps) / quantity.scale,
        error.end / quantity.scale,
    )


def _octaves(points: Sequence[_Point]) -> list[_Point]:
    """The run with the largest error of each octave of steps, below the coarsest, that has enough
    of them; coarse to fine."""
    if not points:
        return []
    finest = min(p.step for p in points)
    held: dict[int, list[_Point]] = {}
    for p in points:
        held.setdefault(math.floor(math.log2(p.step / finest) + 1e-9), []).append(p)
    full = [group for _, group in sorted(held.items(), reverse=True) if len(group) >= PER_OCTAVE]
    return [max(group, key=lambda p: p.error) for group in full]


def _stalled(octaves: Sequence[_Point]) -> bool:
    return octaves[-1].error >= STALLED * octaves[-3].error


def _slope(octaves: Sequence[_Point]) -> tuple[float, float, float] | None:
    """Slope of the envelope with its 95 % confidence interval, over the finest octaves, four or
    more, over which the interval lies above the slowest; the finest four have to fall as fast."""
    steps, errors = [p.step for p in octaves], [p.error for p in octaves]
    none = [0.0] * len(steps)
    for most in range(OCTAVES, len(octaves) + 1):
        fit = fit_order(steps, errors, none, most)
        if fit is None or (most == OCTAVES and not fit.slope > SLOWEST):
            return None
        if fit.low > SLOWEST:
            return fit.slope, fit.low, fit.high
    return None


def _extrapolated(points: Sequence[_Point], order: int) -> float | None:
    """The magnitude of the error at the end, extrapolated to a step of zero by a series that begins
    with this order; None where the error is not smooth in the step."""
    ends: Array = np.array([p.end for p in points])
    x = np.array([p.step for p in points]) / points[0].step
    terms = np.stack([np.ones_like(x), x**order, x ** (order + 1)], axis=1)
    weights = 1.0 / np.abs(x**order)
    coefficients = np.linalg.lstsq(terms * weights[:, None], ends * weights, rcond=None)[0]
    left = np.abs(terms @ coefficients - ends) * weights
    if left.max() > SMOOTH * float(np.abs(ends * weights).min()):
        return None
    return float(abs(coefficients[0]))
