"""Explicit Runge-Kutta methods as data, and one step of any of them on states of any kind."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from operator import add
from typing import Any

Slopes = Callable[[float, Sequence[Any]], Sequence[Any]]
"""The slopes of all parts of a state at a fraction of the step: series, arrays or numbers."""


def moved(parts: Sequence[Any], rates: Sequence[Any], step: Any) -> Sequence[Any]:
    """The parts of a state that change at these rates for a step."""
    return [x + step * rate for x, rate in zip(parts, rates, strict=True)]


@dataclass(frozen=True)
class Tableau:
    """An explicit method's Butcher tableau: a row of `matrix` for each of its `nodes`; `weights`
    are over their common `divisor`."""

    order: int
    nodes: tuple[float, ...]
    weights: tuple[float, ...]
    matrix: tuple[tuple[float, ...], ...]
    divisor: float = 1.0

    def slopes(self, slopes_at: Slopes, state: Sequence[Any], step: Any) -> Sequence[Any]:
        """The weighted sums of the slopes of each part of `state` in a `step`, to be divided by
        `divisor`."""
        stages: list[Sequence[Any]] = []
        for node, row in zip(self.nodes, self.matrix, strict=True):
            stage = state
            for weight, slope in zip(row, stages, strict=False):
                if weight:
                    stage = moved(stage, slope, weight * step)
            stages.append(slopes_at(node, stage))
        return _weighted(self.weights, stages)

    def advanced(self, slopes_at: Slopes, state: Sequence[Any], step: Any) -> Sequence[Any]:
        """The parts of `state` after a `step`."""
        return moved(state, self.slopes(slopes_at, state, step), step / self.divisor)

    def change(self, slope: Callable[[Any, Any], Any], time: Any, state: Any, step: Any) -> Any:
        """Change of `state` in a `step` [s] from `time` [s] under its rate `slope(time, state)`;
        arrays of any shapes that broadcast."""
        (total,) = self.slopes(lambda part, z: (slope(time + part * step, *z),), (state,), step)
        return step / self.divisor * total


def _weighted(weights: Sequence[float], stages: Sequence[Sequence[Any]]) -> Sequence[Any]:
    # A sum is twice as fast as a product with a number, which numpy converts.
    parts = [
        slopes if w == 1.0 else [k + k if w == 2.0 else w * k for k in slopes]
        for w, slopes in zip(weights, stages, strict=True)
        if w
    ]
    return reduce(lambda total, part: list(map(add, total, part)), parts)


CLASSICAL = Tableau(
    4,
    (0.0, 0.5, 0.5, 1.0),
    (1.0, 2.0, 2.0, 1.0),
    ((), (0.5,), (0.0, 0.5), (0.0, 0.0, 1.0)),
    divisor=6.0,
)


@cache
def order_8() -> Tableau:
    """The method of order 8 in twelve stages by Dormand and Prince (Hairer, Norsett and Wanner
    1993, Solving ODEs I, II.5), with scipy's coefficients."""
    from scipy.integrate import DOP853

    rows = tuple(tuple(row[:i]) for i, row in enumerate(DOP853.A.tolist()))
    return Tableau(8, tuple(DOP853.C.tolist()), tuple(DOP853.B.tolist()), rows)
