"""Explicit Runge-Kutta methods as data, and one step of any of them on states of any kind."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from itertools import repeat
from operator import add
from typing import Any

Moved = Callable[[Any, Any, float, float], Any]
"""A state moved along a slope for a multiple of the step, and a divisor of that."""

Slopes = Callable[[float, Sequence[Any]], Sequence[Any]]
"""The slopes of all parts of a state at a fraction of the step: series, arrays or numbers."""


@dataclass(frozen=True)
class Tableau:
    """An explicit method's Butcher tableau: a row of `matrix` for each of its `nodes`; `weights`
    are over their common `divisor`."""

    order: int
    nodes: tuple[float, ...]
    weights: tuple[float, ...]
    matrix: tuple[tuple[float, ...], ...]
    divisor: float = 1.0

    def slopes(self, slopes_at: Slopes, state: Sequence[Any], moved: Moved) -> list[Any]:
        """The weighted sums of the slopes of each part of `state`, to be divided by `divisor`;
        `moved` moves a part along a slope."""
        stages: list[Sequence[Any]] = []
        for node, row in zip(self.nodes, self.matrix, strict=True):
            stage = state
            for weight, slope in zip(row, stages, strict=False):
                if weight:
                    stage = list(map(moved, stage, slope, repeat(weight), repeat(1.0)))
            stages.append(slopes_at(node, stage))
        return [_weighted(self.weights, parts) for parts in zip(*stages, strict=True)]

    def advanced(self, slopes_at: Slopes, state: Sequence[Any], moved: Moved) -> list[Any]:
        """The parts of `state` after a step."""
        sums = self.slopes(slopes_at, state, moved)
        return list(map(moved, state, sums, repeat(1.0), repeat(self.divisor)))

    def change(self, slope: Callable[[Any, Any], Any], time: Any, state: Any, step: Any) -> Any:
        """Change of `state` in a `step` [s] from `time` [s] under its rate `slope(time, state)`;
        arrays of any shapes that broadcast."""

        def slopes_at(fraction: float, stage: Sequence[Any]) -> Sequence[Any]:
            return (slope(time + fraction * step, stage[0]),)

        return step / self.divisor * self.slopes(slopes_at, (state,), along(step))[0]


def along(step: Any) -> Moved:
    """Numbers or arrays moved along a slope for a multiple of `step`."""
    length = cache(lambda multiple, divisor: multiple * step / divisor)
    return lambda state, slope, multiple, divisor: state + length(multiple, divisor) * slope


def _weighted(weights: Sequence[float], slopes: Sequence[Any]) -> Any:
    # A sum is twice as fast as a product with a number, which numpy converts.
    parts = [
        k if w == 1.0 else k + k if w == 2.0 else w * k
        for w, k in zip(weights, slopes, strict=True)
        if w
    ]
    return reduce(add, parts)


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
