"""Explicit Runge-Kutta methods as data, and one step of any of them.

The parts of a state are numbers, arrays or power series.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from operator import add
from typing import Any

Slopes = Callable[[float, Sequence[Any]], Sequence[Any]]
"""Function from a fraction of the step and a state to the slopes of all parts of the state."""


def moved(parts: Sequence[Any], rates: Sequence[Any], step: Any) -> Sequence[Any]:
    """Returns the `parts` of a state after changing at constant `rates` for a `step`."""
    return [x + step * rate for x, rate in zip(parts, rates, strict=True)]


@dataclass(frozen=True)
class Tableau:
    """Butcher tableau of an explicit method."""

    order: int
    nodes: tuple[float, ...]  # fractions of the step at which the stages are
    weights: tuple[float, ...]  # weights of the stages times `divisor`
    matrix: tuple[tuple[float, ...], ...]  # one row for each node
    divisor: float = 1.0

    def slopes(self, slopes_at: Slopes, state: Sequence[Any], step: Any) -> Sequence[Any]:
        """Returns the mean slope of each part of `state` in a `step`, times `divisor`."""
        stages: list[Sequence[Any]] = []
        for node, row in zip(self.nodes, self.matrix, strict=True):
            stage = state
            for weight, slope in zip(row, stages, strict=False):
                if weight:
                    stage = moved(stage, slope, weight * step)
            stages.append(slopes_at(node, stage))
        return _weighted_sum(self.weights, stages)

    def advanced(self, slopes_at: Slopes, state: Sequence[Any], step: Any) -> Sequence[Any]:
        """Returns the parts of `state` after a `step`."""
        return moved(state, self.slopes(slopes_at, state, step), step / self.divisor)

    def change(self, slope: Callable[[Any, Any], Any], time: Any, state: Any, step: Any) -> Any:
        """Returns the change of `state` in a `step` [s] from `time` [s] under its rate
        `slope(time, state)`; the arrays broadcast."""

        def slopes_at(fraction: float, parts: Sequence[Any]) -> Sequence[Any]:
            return (slope(time + fraction * step, *parts),)

        (total,) = self.slopes(slopes_at, (state,), step)
        return step / self.divisor * total


def _weighted_sum(weights: Sequence[float], stages: Sequence[Sequence[Any]]) -> Sequence[Any]:
    """Returns the weighted sum of the stages' slopes, for each part of the state."""
    terms = [
        _multiple(weight, slopes)
        for weight, slopes in zip(weights, stages, strict=True)
        if weight
    ]
    return reduce(lambda total, term: list(map(add, total, term)), terms)


def _multiple(weight: float, slopes: Sequence[Any]) -> Sequence[Any]:
    """Returns a multiple of each of the `slopes`."""
    if weight == 1.0:
        return slopes
    if weight == 2.0:
        # A sum takes half the time of a product with a number, which numpy would have to convert.
        return [slope + slope for slope in slopes]
    return [weight * slope for slope in slopes]


CLASSICAL = Tableau(
    order=4,
    nodes=(0.0, 0.5, 0.5, 1.0),
    weights=(1.0, 2.0, 2.0, 1.0),
    matrix=((), (0.5,), (0.0, 0.5), (0.0, 0.0, 1.0)),
    divisor=6.0,
)


@cache
def order_8() -> Tableau:
    """Returns the method of order 8 in twelve stages by Dormand and Prince (Hairer, Norsett and
    Wanner 1993, Solving ODEs I, II.5), with scipy's coefficients."""
    from scipy.integrate import DOP853

    rows = tuple(tuple(row[:i]) for i, row in enumerate(DOP853.A.tolist()))
    return Tableau(8, tuple(DOP853.C.tolist()), tuple(DOP853.B.tolist()), rows)
