"""What a planner asks of a track: where the slider may go, and how quickly."""

from __future__ import annotations

from typing import Protocol

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Point
from plumbob.analytic.systems.planner.lines import Push, Rail
from plumbob.analytic.systems.planner.manoeuvre import Manoeuvre
from plumbob.analytic.systems.planner.turns import Circle
from plumbob.analytic.systems.three_points.equations import Complex

NEAR = 1e-12  # [m] two places of the slider this near are one

Legs = tuple[tuple[Rail, float], ...]
"""Rails, each with the distance [m] that the body goes along it."""


class Track(Protocol):
    """What a planner asks of a track; a place on it is a complex number of the track's own."""

    def places(self, point: Point) -> tuple[complex, ...]:
        """Every place at `point` relative to C [m]; raises ParameterError if there is none."""
        ...

    def circle(self, sense: float, returning: bool) -> Circle:
        """The part of the circle for turns of that `sense`, the slider going back after each one
        if `returning` is asked for or the track needs it."""
        ...

    def on_circle(self, angle: float) -> complex:
        """The place on the circle at `angle` [rad]."""
        ...

    def legs(self, displacement: complex) -> tuple[Legs, ...]:
        """Ways to carry the body over `displacement` [m], in body axes."""
        ...

    def line_time(self, push: Push, displacements: Complex) -> Array:
        """About the time [s], shape (n,), of lines for `displacements` [m], shape (n,), in body
        axes."""
        ...

    def route(self, begin: complex, end: complex) -> tuple[Manoeuvre, ...]:
        """The quickest slow motions from one place to another."""
        ...
