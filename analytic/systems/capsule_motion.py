"""The interface of all motions of the capsule, so that no caller asks for a class."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from plumbob.analytic.systems.slider_path import SliderPath

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


class CapsuleMotion(Protocol):
    """A motion of body and slider from the start of a scene."""

    @property
    def kind(self) -> MotionKind:
        """The kind of motion, see `MotionKind`."""
        ...

    @property
    def single(self) -> CapsuleMotion:
        """The motion that is repeated, with its events where it has no formula; else itself."""
        ...

    @property
    def count(self) -> int:
        """How often `single` is repeated, 1 or more."""
        ...

    @property
    def period(self) -> float:
        """Time from the start of one `single` to that of the next [s], infinite for motions that
        are not repeated."""
        ...

    @property
    def path(self) -> SliderPath:
        """The slider's path in the body, to the end of the last repetition."""
        ...

    @property
    def sliding_time(self) -> float:
        """How long the body moves in one `single` before it rests [s]."""
        ...
