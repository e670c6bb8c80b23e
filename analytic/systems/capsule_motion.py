"""Attributes that all motions of the capsule share, so that no caller has to ask for a motion's
class."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal, Self

MotionKind = Literal["line", "repeated-line", "stroke", "hold", "coasting", "plane"]
"""The kind of a motion, a key of tables of theory. Body and slider move along a line, once
("line") or repeatedly ("repeated-line"); the slider moves alone ("stroke"); nothing moves ("hold");
the body moves alone, in closed form ("coasting"); the body moves in the plane and there is no
formula ("plane")."""


@dataclass(frozen=True)
class Demand:
    """A motion's demand on its actuator: peak and root mean square of the force over the motion
    [N], and the peak power given to the slider in the body [W]."""

    peak: float
    rms: float
    power: float

    def facts(self) -> dict[str, float]:
        """Returns the numbers by name, as `solve` and `plan` report them."""
        return {
            "driving_force_peak": self.peak,
            "driving_force_rms": self.rms,
            "driving_power_peak": self.power,
        }


class SingleMotion:
    """A motion of body and slider that is not repeated.

    Every motion of the capsule has a `kind`, the slider's `path` in the body to the end of the last
    repetition, and the motion `single` that it repeats `count` times, once every `period` [s]. In
    `single` the body moves for the `sliding_time` [s].
    """

    count: ClassVar[int] = 1
    period: ClassVar[float] = math.inf

    @property
    def single(self) -> Self:
        """The motion that is repeated: this motion, which is done once."""
        return self
