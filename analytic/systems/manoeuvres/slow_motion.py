"""Slow motion: the slider moves while static friction keeps the body at rest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from plumbob.analytic.parameters import ParameterError, check_fields, finite, positive
from plumbob.analytic.systems.capsule import Capsule, check_loads
from plumbob.analytic.systems.capsule_motion import MotionKind, SingleMotion
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.manoeuvres.line_motion import LineMotion, Phase


def proper_fraction(name: str, value: float) -> float:
    """Returns `value` if it is above 0 and at most 1. Raises ParameterError naming the parameter
    `name`."""
    if not 0.0 < finite(name, value) <= 1.0:
        raise ParameterError(name, value, "above 0 and at most 1")
    return float(value)


@dataclass(frozen=True)
class SlowStroke(SingleMotion, LineMotion):
    """The slider moves along a line through C, out and optionally back, while the body sticks.

    Each way has the acceleration W for half its time and -W for the other half, W = `fraction` f
    g/mu [m/s^2]: the quickest motion from rest to rest under |w| <= W. `length` [m] is signed along
    `direction` [rad, from the body's x axis]. The slider starts at `start` [m] on that line, signed
    from C. At fraction 1 static friction is at its limit. Raises ParameterError. Chernousko 2020,
    eq. 21.
    """

    capsule: Capsule
    length: float
    fraction: float = 1.0
    direction: float = 0.0
    start: float = 0.0
    there_and_back: bool = True
    kind: ClassVar[MotionKind] = "stroke"
    sliding_time: ClassVar[float] = 0.0

    def __post_init__(self) -> None:
        check_fields(self, others=("capsule", "fraction", "there_and_back"))
        positive("friction", self.capsule.friction)
        proper_fraction("fraction", self.fraction)
        positive("duration", self.duration)
        check_loads(self.capsule, self.ends)

    @cached_property
    def phases(self) -> tuple[Phase, ...]:
        """The two halves of each way, and rest. The body does not move."""
        senses = (1.0, -1.0, -1.0, 1.0, 0.0) if self.there_and_back else (1.0, -1.0, 0.0)
        state = Phase(start=0.0, stroke=0.0, stroke_rate=0.0, pull=0.0)
        phases = list[Phase]()
        for sense in senses:
            state = state._replace(pull=sense * math.copysign(self.acceleration, self.length))
            phases.append(state)
            state = state.after(0.5 * self.one_way)
        return tuple(phases)

    @property
    def stroke(self) -> float:
        """The slider's displacement on the way out [m]."""
        return self.length

    @property
    def acceleration(self) -> float:
        """Magnitude W of the slider's acceleration [m/s^2]."""
        return self.fraction * self.capsule.holding_acceleration

    @property
    def one_way(self) -> float:
        """Time for one way [s], 2 sqrt(|length|/W)."""
        return 2.0 * math.sqrt(abs(self.length) / self.acceleration)

    @property
    def duration(self) -> float:
        """Time from the start to the slider's final rest [s]."""
        return self.one_way * (2 if self.there_and_back else 1)


def slow_return(manoeuvre: LineManoeuvre, fraction: float = 1.0) -> SlowStroke:
    """Returns the slow motion of the slider back to the place where `manoeuvre` began. Raises
    ParameterError. Chernousko 2020, end of the section on rectilinear motions."""
    return SlowStroke(
        capsule=manoeuvre.capsule,
        length=-manoeuvre.stroke,
        fraction=fraction,
        direction=manoeuvre.direction,
        start=manoeuvre.start + manoeuvre.stroke,
        there_and_back=False,
    )
