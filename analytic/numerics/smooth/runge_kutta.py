"""Explicit Runge-Kutta methods as tableaux, and one step of any of them on states of any shape."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any


@dataclass(frozen=True)
class Tableau:
    """An explicit method's Butcher tableau: a row of `matrix` for each of its `nodes`."""

    nodes: Sequence[float]
    weights: Sequence[float]
    matrix: Sequence[Sequence[float]]

    def increment(self, slope: Callable[[Any, Any], Any], time: Any, state: Any, step: Any) -> Any:
        """Change of `state` in a `step` [s] from `time` [s] under its rate `slope(time, state)`;
        arrays of any shapes that broadcast."""
        slopes: list[Any] = []
        for node, row in zip(self.nodes, self.matrix, strict=True):
            ahead = state + step * _weighted(row, slopes) if slopes else state
            slopes.append(slope(time + node * step, ahead))
        return step * _weighted(self.weights, slopes)


def _weighted(weights: Sequence[float], slopes: Sequence[Any]) -> Any:
    return sum(w * k for w, k in zip(weights, slopes, strict=False) if w)


CLASSICAL = Tableau(
    (0.0, 0.5, 0.5, 1.0), (1 / 6, 1 / 3, 1 / 3, 1 / 6), ((), (0.5,), (0.0, 0.5), (0.0, 0.0, 1.0))
)


@cache
def order_8() -> Tableau:
    """The method of order 8 in twelve stages by Dormand and Prince (Hairer, Norsett and Wanner
    1993, Solving ODEs I, II.5), with scipy's coefficients."""
    from scipy.integrate import DOP853

    return Tableau(DOP853.C.tolist(), DOP853.B.tolist(), DOP853.A.tolist())
