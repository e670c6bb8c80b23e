"""Parts that the motions of the capsule have in common, so that no caller asks for a class."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal, Self

MotionKind = Literal["line", "repeated-line", "stroke", "hold", "coasting", "plane"]
"""The moving parts, as a key for tables of theory: body and slider along a line, once or
repeatedly; the slider alone; nothing; the body alone in closed form; or the body in the plane with
no formula."""


@dataclass(frozen=True)
class Demand:
    """A motion's demand on its actuator: peak [N] and root mean square [N] of the force over the
    motion, and peak [W] of the power given to the slider in the body."""

    peak: float
    rms: float
    power: float

    def facts(self) -> dict[str, float]:
        """By name, as `solve` and `plan` report it."""
        return {
            "driving_force_peak": self.peak,
            "driving_force_rms": self.rms,
            "driving_power_peak": self.power,
        }


class SingleMotion:
    """A motion of body and slider that is not repeated. Every motion of the capsule has a `kind`,
    the slider's `path` in the body to the end of the last repetition, the `single` motion, in which
    the body moves for the `sliding_time` [s], how often that is repeated, and at which period
    [s]."""

    count: ClassVar[int] = 1
    period: ClassVar[float] = math.inf

    @property
    def single(self) -> Self:
        """The motion that is repeated, with its events where it has no formula: itself."""
        return self
