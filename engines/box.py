"""A box of parameters of a scene: its sides, the points of its grid, and their cases."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError, known
from plumbob.analytic.reference import Array, NoAnswer, answering
from plumbob.engines.exact_budget import integrated
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Case

# [s] processor time allowed for integrating the exact motion at a place
EXACT_MOTION_SECONDS = 10.0


@dataclass(frozen=True)
class Side:
    """A parameter that varies from `low` to `high`, both included, in SI units and radians."""

    name: str
    low: float
    high: float
    logarithmic: bool = False  # whether values are spaced by ratios

    def at(self, fraction: float) -> float:
        """The value at a fraction of the side, 0 to 1."""
        if fraction in (0.0, 1.0):
            return self.high if fraction else self.low
        if self.logarithmic:
            value = math.exp(_between(math.log(self.low), math.log(self.high), fraction))
        else:
            value = _between(self.low, self.high, fraction)
        return min(max(value, self.low), self.high)

    def fraction(self, value: float) -> float:
        """The place of a value on the side: 0 at the low end, 1 at the high end, and outside that
        interval beyond the ends."""
        if self.logarithmic:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def values(self, count: int) -> Array:
        """Returns `count` values from the low to the high end, shape (count,)."""
        return np.array([self.at(number / max(count - 1, 1)) for number in range(count)])


@dataclass(frozen=True)
class Box:
    """A scene with some parameters changed, and others varied along sides."""

    scene: str
    changes: tuple[tuple[str, Any], ...]
    sides: tuple[Side, ...]

    def parameters(self, place: Sequence[float]) -> Mapping[str, Any]:
        """The changed parameters at a place of the box: a fraction of each side, shape (sides,)."""
        varied = {
            side.name: side.at(fraction)
            for side, fraction in zip(self.sides, place, strict=True)
        }
        return {**dict(self.changes), **varied}

    def case(self, place: Sequence[float]) -> Case:
        """The case at a place. Raises NoAnswer if the equations have no solution there, double
        precision does not determine it, or integrating it takes longer than
        `EXACT_MOTION_SECONDS`."""
        try:
            with answering():
                case = case_of(find_scene(self.scene, self.parameters(place)))
                _integrated(case)
                case.reference.observe(np.array([case.scene.duration]))  # known to its end
                return case
        except ParameterError as error:
            raise NoAnswer(f"{error.name} must be {error.requirement}") from error


def _integrated(case: Case) -> None:
    """Integrates the exact motion of a case to its end if it has no closed form; raises NoAnswer if
    that takes longer than `EXACT_MOTION_SECONDS`."""
    duration = case.scene.duration
    until = integrated(case, duration, EXACT_MOTION_SECONDS, lambda reached, spent: None)
    if until < duration:
        known = f"certified up to {until:.3g} s of {duration:g} s"
        raise NoAnswer(
            f"the exact motion is {known} within its budget, {EXACT_MOTION_SECONDS:g} s"
        )


def box(scene: str, changes: Mapping[str, Any], sides: Sequence[Side]) -> Box:
    """The box of a scene with these changes and sides. Raises ParameterError if a scene or a name
    is unknown, a varied parameter is not a single number, or a side is given twice or also
    changed."""
    changed_scene = find_scene(scene, changes)
    known({side.name: side.low for side in sides}, system_of(changed_scene).parameters)
    names = [side.name for side in sides]
    for number, name in enumerate(names):
        if name in changes:
            raise ParameterError("set", name, "a parameter that is not varied")
        if name in names[:number]:
            raise ParameterError("vary", name, "given once")
        usual = changed_scene.parameters.get(name, sides[number].low)
        if isinstance(usual, bool) or not isinstance(usual, (int, float)):
            raise ParameterError("vary", name, f"a parameter with one number, not {usual!r}")
    return Box(changed_scene.name, tuple(changes.items()), tuple(sides))


def _between(low: float, high: float, fraction: float) -> float:
    """The linear interpolation between two values."""
    return low + fraction * (high - low)
