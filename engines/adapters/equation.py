"""A scene as an equation of motion in one coordinate or several."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.engines.trajectory import ByName

State = tuple[Any, Any]
"""Coordinates and rates: floats where there is one coordinate, arrays of shape (n,) for several."""


@dataclass(frozen=True)
class Equation:
    """x'' = acceleration(t, x, x') with its start and the scales of its motion.

    With one coordinate x, x' and x'' are plain floats, with n coordinates arrays of shape (n,).
    Angles and lengths may be mixed if one `size` and one `speed` suit them all.
    """

    acceleration: Callable[[float, Any, Any], Any]  # of time [s], x and x'
    position: Any  # x at time 0: a float, or shape (n,)
    rate: Any  # x' at time 0: a float, or shape (n,)
    speed: float  # x' that no motion of this energy exceeds; also the scale of tolerances
    damping_rate: float | None = None
    """[1/s]: the acceleration depends on x' by -damping_rate x' alone (0: not at all); None if by
    more than that, or if it is not known."""
    limits: ByName = field(default_factory=dict)
    """Magnitudes of observables that only a diverged run exceeds."""
    names: tuple[str, ...] = ("theta",)  # observables that are the coordinates
    rate_names: tuple[str, ...] = ("theta_dot",)  # observables that are their rates
    size: float = 1.0  # scale of x for tolerances: 1 rad for an angle
    read: Callable[[Array, Array], Signals] = lambda x, v: {}
    """Further observables of x and x', shape (n, samples) each."""
    restitution: float | None = None
    """Of a floor at x = 0, where the acceleration presses; None: there is none. One coordinate."""

    @property
    def start(self) -> State:
        """Coordinates and rates at time 0; arrays are copies."""
        if len(self.names) == 1:
            return self.position, self.rate
        return np.array(self.position, dtype=np.float64), np.array(self.rate, dtype=np.float64)

    def slope(self, position: Any, rate: Any) -> Any:
        """Rate of the coordinates."""
        return rate

    def drifted(self, position: Any, rate: Any, h: float) -> Any:
        """Coordinates after the time `h` [s] at a constant rate."""
        return position + h * rate

    def observed(self, states: Sequence[State]) -> Signals:
        """The observables of `states`, each of shape (len(states),)."""
        positions, rates = (
            np.array(part, dtype=np.float64).reshape(len(states), -1).T
            for part in zip(*states, strict=True)
        )
        observables = dict(zip(self.names, positions, strict=True))
        rest = self.read(positions, rates)
        return {**observables, **dict(zip(self.rate_names, rates, strict=True)), **rest}
