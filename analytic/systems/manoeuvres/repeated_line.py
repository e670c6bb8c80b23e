"""Repeated line manoeuvres, with a slow return of the slider after each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from plumbob.analytic.parameters import counting, non_negative
from plumbob.analytic.systems.capsule_motion import MotionKind
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.manoeuvres.line_motion import LineMotion, Phase
from plumbob.analytic.systems.manoeuvres.slow_motion import SlowStroke, slow_return


@dataclass(frozen=True)
class RepeatedLine(LineMotion):
    """`count` equal line manoeuvres. Each is followed by a slow return at `fraction` of f g/mu and
    by `pause` [s] of rest.

    The pause can put every start on a grid of steps: then the error of a fixed step is `count`
    times that of one manoeuvre. Raises ParameterError. Chernousko 2020, end of the section on
    rectilinear motions.
    """

    manoeuvre: LineManoeuvre
    count: int
    fraction: float = 1.0
    pause: float = 0.0
    kind: ClassVar[MotionKind] = "repeated-line"

    def __post_init__(self) -> None:
        counting("count", self.count)
        non_negative("pause", self.pause)
        _ = self.return_motion  # raises ParameterError for a wrong fraction

    @cached_property
    def return_motion(self) -> SlowStroke:
        """The slow return after each manoeuvre."""
        return slow_return(self.manoeuvre, self.fraction)

    @property
    def single(self) -> LineManoeuvre:
        """The manoeuvre that is repeated."""
        return self.manoeuvre

    @cached_property
    def phases(self) -> tuple[Phase, ...]:
        """The phases of one manoeuvre and of the return after it. The manoeuvre's last phase is its
        state at the end, where the return begins."""
        *line_phases, end = self.manoeuvre.phases  # `end` has no duration
        return_phases = [
            phase._replace(
                start=end.start + phase.start,
                stroke=end.stroke + phase.stroke,
                displacement=end.displacement,
            )
            for phase in self.return_motion.phases
        ]
        return (*line_phases, *return_phases)

    @property
    def period(self) -> float:
        """Time from the start of one manoeuvre to the start of the next [s]."""
        return self.manoeuvre.t2 + self.return_motion.duration + self.pause

    @property
    def duration(self) -> float:
        """Time from the start to the final rest of body and slider [s]."""
        return self.count * self.period

    @property
    def displacement(self) -> float:
        """The body's total displacement along the line [m]: count times eq. 22."""
        return self.count * self.manoeuvre.displacement

    @property
    def mean_speed(self) -> float:
        """Magnitude of the body's displacement in one period over the period [m/s]."""
        return abs(self.manoeuvre.displacement) / self.period
