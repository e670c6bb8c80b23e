"""A scene as an equation of motion in one coordinate or several."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.engines.trajectory import ByName

State = tuple[Any, Any]
"""Coordinates and rates: floats for one coordinate, arrays of shape (n,) for n coordinates."""


@dataclass(frozen=True)
class Equation:
    """x'' = acceleration(t, x, x') with its start and the scales of its motion.

    With one coordinate x, x' and x'' are plain floats, with n coordinates arrays of shape (n,).
    Angles and lengths may be mixed if one `size` and one `speed` suit them all.
    """

    acceleration: Callable[[float, Any, Any], Any]  # x'' as a function of time [s], x and x'
    position: Any  # x at time 0: a float, or shape (n,)
    rate: Any  # x' at time 0: a float, or shape (n,)
    speed: float  # x' that no motion of this energy exceeds; also the scale of tolerances
    damping_rate: float | None = None
    """[1/s] if the acceleration depends on x' only by the term -damping_rate x', 0 if it does not
    depend on x'; None if it depends on x' in another way, or if that is not known."""
    limits: ByName = field(default_factory=dict)
    """Magnitudes of observables that only a diverged run exceeds."""
    names: tuple[str, ...] = ("theta",)  # names of the observables that are the coordinates
    rate_names: tuple[str, ...] = ("theta_dot",)  # names of the observables that are the rates
    size: float = 1.0  # scale of x for tolerances: 1 rad for an angle
    read: Callable[[Array, Array], Signals] = lambda x, v: {}
    """x and x', shape (n, samples) each -> further observables."""
    restitution: float | None = None
    """Restitution of a floor at x = 0 toward which the acceleration points, for one coordinate;
    None if there is no floor."""

    @property
    def start(self) -> State:
        """The coordinates and rates at time 0; arrays are copies."""
        if len(self.names) == 1:
            return self.position, self.rate
        return np.array(self.position, dtype=np.float64), np.array(self.rate, dtype=np.float64)

    def slope(self, position: Any, rate: Any) -> Any:
        """The derivatives of the coordinates by time: here the rates."""
        return rate

    def drifted(self, position: Any, rate: Any, h: float) -> Any:
        """The coordinates after the time `h` [s] at a constant rate."""
        return position + h * rate

    def observed(self, states: Sequence[State]) -> Signals:
        """The observables of `states`, shape (len(states),) each."""
        positions, rates = (
            np.array(part, dtype=np.float64).reshape(len(states), -1).T
            for part in zip(*states, strict=True)
        )
        observables = dict(zip(self.names, positions, strict=True))
        observables |= zip(self.rate_names, rates, strict=True)
        return {**observables, **self.read(positions, rates)}
