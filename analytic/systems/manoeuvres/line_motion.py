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
    Point,
    by_support,
    normal_force_uncertainty,
    normal_forces,
)
from plumbob.analytic.systems.manoeuvres.driving_force import driving_force
from plumbob.analytic.systems.slider_path import SliderPath, StraightPiece

# A time this near a switch, relatively, counts as the switch: a step that begins there is rounded.
SNAP = 2.0**-48
# Relative rounding of a term: three parameters with three roundings each, and nine operations.
FEW = 27 * ROUNDOFF
SHIFTED = 8  # roundings of a time in a repetition, of earlier switches and of the period


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
    def ends(self) -> tuple[Point, Point]:
        """The two ends of the slider's stroke, relative to C in body axes [m]."""
        x, y = (float(c) for c in self.unit)
        end = self.single.start + self.single.stroke
        return (self.single.start * x, self.single.start * y), (end * x, end * y)

    @cached_property
    def path(self) -> SliderPath:
        """The slider's path in the body over all repetitions."""
        pulled = [
            next(alike) for _, alike in groupby(self.phases, key=lambda phase: phase.pull)
        ]
        ends = [phase.start for phase in pulled[1:]]
        place = self.ends[0]
        direction = self.single.direction
        if math.isfinite(self.period) or not ends:
            ends.append(self.period if ends else 0.0)
        pieces = tuple(
            StraightPiece(end - p.start, place, direction, p.stroke, p.stroke_rate, p.pull)
            for p, end in zip(pulled, ends, strict=False)
        )
        return SliderPath(self.count * pieces)

    @cached_property
    def _table(self) -> Array:
        """The phases, one column each, shape (8, phases)."""
        return np.array(self.phases, dtype=float).T

    def _now(self, times: Array) -> tuple[Array, Array, Array]:
        """Returns the number of complete repetitions before `times` [s], the time spent in the
        present phase [s], both of shape (n,), and that phase, shape (8, n)."""
        times = np.asarray(times, dtype=float)
        late = times * (1.0 + SNAP)
        done = np.zeros_like(times)
        if self.count > 1:
            done = np.clip(np.floor(late / self.period), 0, self.count - 1)
            times = times - done * self.period
            late = late - done * self.period
        which = np.searchsorted(self._table[0], np.maximum(late, 0.0), side="right") - 1
        phase = self._table[:, which]
        return done, np.maximum(times - phase[0], 0.0), phase

    def at(self, times: Array) -> Any:
        """Returns the state at `times` [s] as a Phase whose fields have the shape (n,) (eqs. 11-16,
        19)."""
        done, spent, phase = self._now(times)
        now: Any = Phase(*phase).after(spent)
        moved = done * self.phases[-1].displacement
        return now._replace(displacement=now.displacement + moved)

    def relative_velocity(self, times: Array) -> Array:
        """Returns the slider's velocity in the body v [m/s] at `times` [s], shape (n,) (eq. 16)."""
        return np.asarray(self.at(times).stroke_rate)

    def friction_force(self, times: Array) -> Array:
        """Returns the resultant of friction on the body [N] at `times` [s], shape (n,): f (M + m) g
        while the body slides backward, and static friction m w while it rests (eqs. 1, 8)."""
        now = self.at(times)
        capsule = self.single.capsule
        sliding = capsule.friction * capsule.weight
        held = capsule.slider_mass * now.pull
        return np.asarray(np.where(now.slides, sliding, held))

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
        now = self.at(times)
        still = np.zeros(np.shape(times))
        return {
            "displacement": now.displacement,
            "velocity": now.velocity,
            "stroke": now.stroke,
            "stroke_rate": now.stroke_rate,
            "heading": still,
            "sideways": still,
            **by_support(self.normal_forces(times)),
            "friction_force": self.friction_force(times),
            "driving_force": self.driving_force(times),
        }

    def uncertainty(self, times: Array) -> Signals:
        """Bound on the error of each observable [SI] at `times` [s], shape (n,), by parameters and
        times rounded to double and by the arithmetic. It is of first order: the magnitudes of all
        terms are added, and it grows with the repetitions."""
        capsule = self.single.capsule
        (done, _, _) = self._now(times)
        late = np.where(done > 0.0, SHIFTED, 2.0) * np.abs(np.asarray(times, dtype=float))
        late = ROUNDOFF * (
            late if self.count > 1 else np.minimum(late, 2 * self.phases[-1].start)
        )
        sizes = self._sizes
        end = sizes[-1]
        pull = max(phase.pull for phase in sizes)
        push = max(phase.acceleration for phase in sizes)
        reach = math.hypot(*self.ends[0]) + abs(self.single.stroke)
        slack = normal_force_uncertainty(capsule, reach, late * end.stroke_rate)
        now = self.at(times)
        held = self.friction_force(times)
        still = np.zeros_like(late)
        return {
            "displacement": FEW * end.displacement * (1.0 + done) + late * end.velocity,
            "velocity": FEW * end.velocity + 2 * late * push,
            "stroke": FEW * end.stroke + late * end.stroke_rate,
            "stroke_rate": FEW * end.stroke_rate + 2 * late * pull,
            "heading": still,
            "sideways": still,
            **dict.fromkeys(NORMAL_FORCES, still + slack),
            "friction_force": still + FEW * capsule.friction * capsule.weight,
            "driving_force": FEW * driving_force(capsule, np.abs(held), np.abs(now.pull)),
        }

    @cached_property
    def _sizes(self) -> list[Phase]:
        """The phases with every acceleration replaced by the sum of its terms' magnitudes, for
        bounds on rounding."""
        capsule = self.single.capsule
        sizes = list[Phase]()
        now = Phase(0.0, 0.0, 0.0, 0.0)
        for phase in self.phases:
            push = capsule.mass_ratio * abs(phase.pull) + capsule.friction * capsule.gravity
            now = now.after(phase.start - now.start)
            now = now._replace(pull=abs(phase.pull), acceleration=phase.slides * push)
            sizes.append(now)
        return sizes
