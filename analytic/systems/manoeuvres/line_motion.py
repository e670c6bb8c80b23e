"""A motion of body and slider along a line through C, in phases of constant acceleration, done once
or repeatedly."""

from __future__ import annotations

import math
from functools import cached_property
from itertools import groupby
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.reference import Array, LinearResponse, Signals
from plumbob.analytic.systems.capsule import (
    NORMAL_FORCES,
    PlanePoint,
    by_support,
    normal_force_uncertainty,
    normal_forces,
)
from plumbob.analytic.systems.manoeuvres.driving_force import driving_force
from plumbob.analytic.systems.slider_path import SliderPath, StraightPiece

# Relative distance from a switch at which a time counts as the switch: times of steps are rounded.
SNAP = 2.0**-48
# Relative rounding of a term: three parameters with three roundings each, and nine operations.
TERM_ROUNDING = 27 * ROUNDOFF
# roundings of a time in a repetition, of earlier switches and of the period
SHIFT_ROUNDINGS = 8


class Phase(NamedTuple):
    """The state at local time `start` [s], and the accelerations from then on. `stroke` is the
    slider's position in the body, `displacement` that of C on the ground [m]; `stroke_rate` and
    `velocity` [m/s] are their rates; `pull` and `acceleration` [m/s^2] their accelerations.
    `slides` is True if the body slides (backward)."""

    start: float
    stroke: float
    stroke_rate: float
    pull: float
    displacement: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0
    slides: bool = False

    def after(self, time: Any) -> Phase:
        """Returns the state after a `time` [s], or after times of shape (n,)."""
        return self._replace(
            start=self.start + time,
            stroke=self.stroke + time * (self.stroke_rate + 0.5 * self.pull * time),
            stroke_rate=self.stroke_rate + self.pull * time,
            displacement=self.displacement
            + time * (self.velocity + 0.5 * self.acceleration * time),
            velocity=self.velocity + self.acceleration * time,
        )


class LineMotion(LinearResponse):
    """Observables of a motion along a line through C. Lengths are signed along the line.

    The motion `single` has a `capsule`, the `direction` of its line [rad, from the body's x axis],
    the slider's first place `start` on it, from C, and the length of its `stroke` [m]. Its `phases`
    are repeated `count` times, once every `period` [s]. A time at which an acceleration switches
    belongs to the interval that begins there. The heading is constant: friction has no moment on
    lines through C, for sum N_i CA_i = m g r.
    """

    if TYPE_CHECKING:  # some motions have these as fields, others as properties

        @property
        def single(self) -> Any: ...
        @property
        def phases(self) -> tuple[Phase, ...]: ...
        @property
        def count(self) -> int: ...
        @property
        def period(self) -> float: ...

    @property
    def unit(self) -> Array:
        """Unit vector of `direction`, shape (2,)."""
        return np.array([math.cos(self.single.direction), math.sin(self.single.direction)])

    @property
    def ends(self) -> tuple[PlanePoint, PlanePoint]:
        """The two ends of the slider's stroke, relative to C in body axes [m]."""
        x, y = self.unit.tolist()
        start = self.single.start
        end = start + self.single.stroke
        return (start * x, start * y), (end * x, end * y)

    @cached_property
    def path(self) -> SliderPath:
        """The slider's path in the body over all repetitions."""
        # Consecutive phases with the same acceleration of the slider are one piece, which begins
        # with the first of them.
        groups = groupby(self.phases, key=lambda phase: phase.pull)
        slider_phases = [next(phases) for _, phases in groups]
        ends = [phase.start for phase in slider_phases[1:]]
        # The final rest of a motion that is not repeated has no end, and is no piece.
        if math.isfinite(self.period) or not ends:
            ends.append(self.period if ends else 0.0)
        pieces = tuple(
            StraightPiece(
                duration=end - phase.start,
                origin=self.ends[0],
                direction=self.single.direction,
                position=phase.stroke,
                speed=phase.stroke_rate,
                acceleration=phase.pull,
            )
            for phase, end in zip(slider_phases, ends, strict=False)
        )
        return SliderPath(self.count * pieces)

    @cached_property
    def _phase_table(self) -> Array:
        """The phases, one column each, shape (8, phases)."""
        return np.array(self.phases, dtype=float).T

    def _phase_at(self, times: Array) -> tuple[Array, Array, Array]:
        """Returns the number of complete repetitions before `times` [s], the time spent in the
        present phase [s], both of shape (n,), and that phase, shape (8, n)."""
        times = np.asarray(times, dtype=float)
        late = times * (1.0 + SNAP)
        repetitions = np.zeros_like(times)
        if self.count > 1:
            repetitions = np.clip(np.floor(late / self.period), 0, self.count - 1)
            times = times - repetitions * self.period
            late = late - repetitions * self.period
        starts = self._phase_table[0]
        numbers = np.searchsorted(starts, np.maximum(late, 0.0), side="right") - 1
        phase = self._phase_table[:, numbers]
        return repetitions, np.maximum(times - phase[0], 0.0), phase

    def at(self, times: Array) -> Any:
        """Returns the state at `times` [s] as a Phase whose fields have the shape (n,) (eqs. 11-16,
        19)."""
        repetitions, elapsed, phase = self._phase_at(times)
        state: Any = Phase(*phase).after(elapsed)
        earlier = repetitions * self.phases[-1].displacement
        return state._replace(displacement=state.displacement + earlier)

    def relative_velocity(self, times: Array) -> Array:
        """Returns the slider's velocity in the body v [m/s] at `times` [s], shape (n,) (eq. 16)."""
        return np.asarray(self.at(times).stroke_rate)

    def friction_force(self, times: Array) -> Array:
        """Returns the resultant of friction on the body [N] at `times` [s], shape (n,): f (M + m) g
        while the body slides backward, and static friction m w while it rests (eqs. 1, 8)."""
        state = self.at(times)
        capsule = self.single.capsule
        sliding = capsule.friction * capsule.weight
        static = capsule.slider_mass * state.pull
        return np.asarray(np.where(state.slides, sliding, static))

    def driving_force(self, times: Array) -> Array:
        """Returns the force F of the actuator on the slider [N] at `times` [s], shape (n,) (eqs. 3,
        9)."""
        friction = self.friction_force(times)
        pull = self.at(times).pull
        return np.asarray(driving_force(self.single.capsule, friction, pull))

    def normal_forces(self, times: Array) -> Array:
        """Returns the normal forces N_i [N] at `times` [s], shape (n, 3)."""
        places = (self.single.start + self.at(times).stroke)[:, None] * self.unit
        return normal_forces(self.single.capsule, places)

    def observe(self, times: Array) -> Signals:
        """Exact observables at `times` >= 0 [s], shape (n,) (Chernousko 2020, eqs. 7-22):
        displacement and velocity of C [m, m/s]; stroke and stroke_rate of the slider in the body
        [m, m/s]; heading [rad]; sideways, the displacement of C across the line [m];
        normal_force_1..3, friction_force (resultant on the body) and driving_force (of the actuator
        on the slider) [N]."""
        state = self.at(times)
        zeros = np.zeros(np.shape(times))
        return {
            "displacement": state.displacement,
            "velocity": state.velocity,
            "stroke": state.stroke,
            "stroke_rate": state.stroke_rate,
            "heading": zeros,
            "sideways": zeros,
            **by_support(self.normal_forces(times)),
            "friction_force": self.friction_force(times),
            "driving_force": self.driving_force(times),
        }

    def uncertainty(self, times: Array) -> Signals:
        """Bound on the error of each observable [SI] at `times` [s], shape (n,), by parameters and
        times rounded to double and by the arithmetic. It is of first order: the magnitudes of all
        terms are added, and it grows with the repetitions."""
        capsule = self.single.capsule
        repetitions, _, _ = self._phase_at(times)
        roundings = np.where(repetitions > 0.0, SHIFT_ROUNDINGS, 2.0)
        time_error = roundings * np.abs(np.asarray(times, dtype=float))
        if self.count == 1:
            time_error = np.minimum(time_error, 2 * self.phases[-1].start)
        time_error = ROUNDOFF * time_error
        magnitudes = self._magnitudes
        end = magnitudes[-1]
        pull = max(phase.pull for phase in magnitudes)
        acceleration = max(phase.acceleration for phase in magnitudes)
        reach = math.hypot(*self.ends[0]) + abs(self.single.stroke)
        load_error = normal_force_uncertainty(capsule, reach, time_error * end.stroke_rate)
        state = self.at(times)
        friction = np.abs(self.friction_force(times))
        zeros = np.zeros_like(time_error)
        return {
            "displacement": TERM_ROUNDING * end.displacement * (1.0 + repetitions)
            + time_error * end.velocity,
            "velocity": TERM_ROUNDING * end.velocity + 2 * time_error * acceleration,
            "stroke": TERM_ROUNDING * end.stroke + time_error * end.stroke_rate,
            "stroke_rate": TERM_ROUNDING * end.stroke_rate + 2 * time_error * pull,
            "heading": zeros,
            "sideways": zeros,
            **dict.fromkeys(NORMAL_FORCES, zeros + load_error),
            "friction_force": zeros + TERM_ROUNDING * capsule.friction * capsule.weight,
            "driving_force": TERM_ROUNDING
            * driving_force(capsule, friction, np.abs(state.pull)),
        }

    @cached_property
    def _magnitudes(self) -> list[Phase]:
        """The phases with every acceleration replaced by the sum of its terms' magnitudes, for
        bounds on rounding."""
        capsule = self.single.capsule
        magnitudes = list[Phase]()
        state = Phase(start=0.0, stroke=0.0, stroke_rate=0.0, pull=0.0)
        for phase in self.phases:
            pull = abs(phase.pull)
            acceleration = capsule.mass_ratio * pull + capsule.friction * capsule.gravity
            state = state.after(phase.start - state.start)
            state = state._replace(pull=pull, acceleration=phase.slides * acceleration)
            magnitudes.append(state)
        return magnitudes
