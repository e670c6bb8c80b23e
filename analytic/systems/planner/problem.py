"""The task of a plan: a rest pose to reach, and limits on the motion."""

from __future__ import annotations

import math
from dataclasses import dataclass

from plumbob.analytic.parameters import ParameterError, check_fields, counting, numbers
from plumbob.analytic.systems.capsule import Capsule, Point
from plumbob.analytic.systems.manoeuvres.slow_motion import proper_fraction

FULL_CIRCLE = 2.0 * math.pi
# largest number of manoeuvres in a plan, which take half a minute to compute
MAX_MANOEUVRES = 1000


@dataclass(frozen=True)
class RestPose:
    """Body and slider at rest: position of C on the ground [m], heading psi [rad], and the slider's
    position relative to C in body axes [m]. Raises ParameterError."""

    x: float
    y: float
    heading: float
    slider: Point = (0.0, 0.0)

    def __post_init__(self) -> None:
        check_fields(self, others=("slider",))
        slider = numbers("slider", self.slider, (2,), "a point (x, y)")
        object.__setattr__(self, "slider", slider)

    @property
    def place(self) -> complex:
        """Position of C on the ground as x + iy [m]."""
        return complex(self.x, self.y)


POSES: tuple[tuple[str, RestPose], ...] = (
    ("near", RestPose(0.1, 0.05, 0.5)),
    ("half-turn", RestPose(0.0, 0.0, math.pi)),
    ("aside", RestPose(-0.15, 0.2, -1.2)),
    ("behind", RestPose(-0.3, -0.1, 2.4)),
    ("ahead", RestPose(0.25, 0.0, 0.0)),
)
"""Goals of example plans that start at rest at the origin, by name."""


@dataclass(frozen=True)
class Limits:
    """Limits on the motions of a plan. Raises ParameterError.

    acceleration: largest |w| of the slider [m/s^2]
    stroke: longest path of the slider in one line or turn [m]
    radius: radius of the circle about C [m]
    holding: largest fraction of the friction limit in a slow motion or while braking
    manoeuvres: largest number of turns and lines together
    """

    acceleration: float = 1000.0
    stroke: float = 0.5
    radius: float = 0.12
    holding: float = 0.9
    manoeuvres: int = 200

    def __post_init__(self) -> None:
        lengths = ("acceleration", "stroke", "radius")
        check_fields(self, lengths, others=("holding", "manoeuvres"))
        proper_fraction("holding", self.holding)
        counting("manoeuvres", self.manoeuvres)
        if self.manoeuvres > MAX_MANOEUVRES:
            reason = "the exact motion of each takes some hundredths of a second"
            need = f"at most {MAX_MANOEUVRES}: {reason}"
            raise ParameterError("manoeuvres", self.manoeuvres, need)


def check_pushing(capsule: Capsule, limits: Limits) -> None:
    """Raises ParameterError if no line manoeuvre moves the body (Chernousko 2020, eq. 15). Turns
    alone do not suffice to reach a pose, for they also shift C."""
    if not limits.acceleration > capsule.holding_acceleration:
        need = f"greater than f g/mu = {capsule.holding_acceleration!r} m/s^2 to move the body"
        raise ParameterError("acceleration", limits.acceleration, need)


def too_many(limits: Limits, needed: int) -> ParameterError:
    """Returns the error for a pose that needs `needed` manoeuvres, more than the limit."""
    return ParameterError(
        "manoeuvres",
        limits.manoeuvres,
        f"at least {needed:.9g} to get there with strokes of {limits.stroke:g} m at most, "
        f"{limits.acceleration:g} m/s^2 and the track as it is",
    )


def to_ten_digits(time: float) -> float:
    """Returns a time [s] rounded to ten digits. If times differ only by rounding, the first one is
    then the minimum."""
    return float(f"{time:.9e}")
