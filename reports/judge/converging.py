"""Convergence of methods that no theory covers: does the error go to zero with the step?

The errors' envelope is the largest error in each octave of steps. The envelope has to fall. If the
error is smooth in the step, its extrapolation to a step of zero has to be zero. The constants are
rules of judgement, chosen and not derived.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array
from plumbob.engines.study.measurement import Measurement, rounding, worst
from plumbob.engines.study.order import fit_order
from plumbob.models.scene import Quantity

PER_OCTAVE = 3  # least runs in an octave of steps: fewer may all be accurate by chance
OCTAVES = 4  # octaves over which the envelope has to fall
SLOWEST = 0.5  # lower bound on the confidence interval of the envelope's slope
ROUND_OFFS = 10.0  # multiple of the round-off level: an error below it is not resolved
STALLED = 0.7  # ratio of errors, two octaves apart, from which smaller steps do not help
SMOOTH = 0.05  # largest residual of the series in the step, relative to the smallest error
LEFT = 0.5  # largest extrapolated error relative to the smallest measured error


@dataclass(frozen=True)
class Convergence:
    """The verdict by the envelope, with the reason: `converges`, `not-converging` or None."""

    verdict: Literal["converges", "not-converging"] | None
    reason: str


def convergence(runs: Sequence[Measurement], quantities: Sequence[Quantity]) -> Convergence:
    """Returns the verdict on the runs of a method without theory, coarse to fine, by their relative
    errors."""
    rows = [row for m in runs if m.status == "done" and (row := _row(m, quantities))]
    steps, errors, floors, ends = np.reshape(rows, (-1, 4)).T
    resolved = errors > ROUND_OFFS * floors
    octaves = _octaves(steps, errors)
    above = octaves[resolved[octaves]]
    if len(octaves) < OCTAVES:
        # A study ends early once its errors reach round-off.
        if len(steps) >= PER_OCTAVE and not resolved.any():
            return Convergence("converges", f"within {ROUND_OFFS:g} round-offs at every step")
        return Convergence(None, f"{len(octaves)} octaves of steps, and {OCTAVES} are needed")
    least = f"the smallest error resolved is {errors[octaves].min():.2g}, relative"
    if not len(above):
        return Convergence(
            "converges", f"within {ROUND_OFFS:g} round-offs at every step; {least}"
        )
    last = octaves[-1]
    if resolved[last] and errors[last] >= STALLED * errors[octaves[-3]]:
        why = f"the relative error stays at {errors[last]:.3g}, "
        times = f"{errors[last] / floors[last]:.2g} times the round-off level"
        return Convergence("not-converging", why + times)
    if len(above) < OCTAVES:
        return Convergence(None, f"{len(above)} octaves above the round-off level; {least}")
    slope = _slope(steps[above].tolist(), errors[above].tolist())
    if slope is None:
        return Convergence(None, f"the error does not fall as a power of the step; {least}")
    return _falling(steps[resolved], errors[resolved], ends[resolved], slope, least)


def _falling(
    steps: Array, errors: Array, ends: Array, slope: tuple[float, float, float], least: str
) -> Convergence:
    """Returns the verdict on errors above round-off whose envelope falls. If they are smooth in the
    step and extrapolate to an error far from zero, they do not converge. `slope` is the envelope's
    slope with its confidence interval; `least` is a phrase on the smallest error."""
    fine = slice(-3 * PER_OCTAVE, None)
    left = _extrapolated(steps[fine], ends[fine], max(1, round(slope[0])))
    if left > LEFT * errors[-1]:
        why = f"the error is smooth in the step, and leads to {left:.2g} and not to zero"
        return Convergence("not-converging", f"{why}; {least}")
    order = "of order {:.2f} ({:.2f} to {:.2f})".format(*slope)
    return Convergence("converges", f"{order}; {least}")


def _row(run: Measurement, quantities: Sequence[Quantity]) -> tuple[float, ...]:
    """Returns four numbers of a run: its step [s], its error, its round-off level, and its signed
    error at the end, all three relative to the scale of the worst quantity. Empty if the run lacks
    a quantity."""
    quantity, relative = worst(run, quantities)
    if math.isnan(relative):
        return ()
    error = run.errors[quantity.observable]
    scale = quantity.scale
    return run.step, relative, rounding(error, run.steps) / scale, error.end / scale


def _octaves(steps: Array, errors: Array) -> npt.NDArray[np.intp]:
    """Returns the indices of the runs with the largest error in each octave of steps, coarse to
    fine. An octave counts if it has PER_OCTAVE runs or more."""
    octave = np.floor(np.log2(steps / steps.min(initial=np.inf)) + 1e-9)
    groups = [np.flatnonzero(octave == k) for k in np.unique(octave)[::-1]]
    full = [group[errors[group].argmax()] for group in groups if len(group) >= PER_OCTAVE]
    return np.array(full, dtype=np.intp)


def _slope(steps: list[float], errors: list[float]) -> tuple[float, float, float] | None:
    """Returns the slope of the envelope and the ends of its 95 % confidence interval, over the
    finest octaves: as many, four or more, as bring the interval above SLOWEST. None if no number of
    octaves does, or if the slope over the finest four is SLOWEST or less."""
    none = [0.0] * len(steps)
    for most in range(OCTAVES, len(steps) + 1):
        fit = fit_order(steps, errors, none, most)
        if fit is None or (most == OCTAVES and not fit.slope > SLOWEST):
            return None
        if fit.low > SLOWEST:
            return fit.slope, fit.low, fit.high
    return None


def _extrapolated(steps: Array, ends: Array, order: int) -> float:
    """Returns the magnitude of the error at the end, extrapolated to a step of zero by a series in
    the step that begins with the power `order`. Returns 0 if the error is not smooth in the
    step."""
    x = steps / steps[0]
    terms = np.stack([np.ones_like(x), x**order, x ** (order + 1)], axis=1)
    weights = 1.0 / np.abs(x**order)
    coefficients = np.linalg.lstsq(terms * weights[:, None], ends * weights, rcond=None)[0]
    left = np.abs(terms @ coefficients - ends) * weights
    if left.max() > SMOOTH * float(np.abs(ends * weights).min()):
        return 0.0
    return float(abs(coefficients[0]))
