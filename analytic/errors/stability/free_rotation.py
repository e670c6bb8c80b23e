"""Largest stable steps on the exact rotation of a free rigid body.

Most schemes step the angular velocity without reading the attitude, and a nudge of the attitude
keeps its size. For these schemes only the angular velocity is stepped (THEORY.md, 12 and 13).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import Any

import numpy as np

from plumbob.analytic.errors.smooth_motion.free_body_errors import (
    SERIES_ORDERS,
    free_body_errors,
    rotation_step,
)
from plumbob.analytic.errors.smooth_motion.scheme_steps import SchemeStep, StateParts
from plumbob.analytic.errors.stability.flow_growth import (
    APERIODIC_PERIODS,
    FlowGrowth,
    eigenvalues,
    growth_along,
)
from plumbob.analytic.errors.stability.followed_runs import long_run_by_series
from plumbob.analytic.errors.stability.largest_step import (
    StableMarks,
    jacobians,
    largest_step,
)
from plumbob.analytic.errors.stability.stepped_growth import (
    FIRST_PASS_RUN_STEPS,
    SteppedMotion,
    limits_by_steps,
    limits_near,
    step_limit,
)
from plumbob.analytic.numerics.smooth.smooth_motion import SmoothMotion
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.schemes import (
    ADAPTIVE,
    CLOSED_FORM,
    LEAPFROG,
    TABLEAUX,
    Scheme,
)
from plumbob.analytic.stability import BAND, NO_STEP, LongRun, StabilityTheory, StepLimit
from plumbob.analytic.systems.free_body.equations import free_rotation
from plumbob.analytic.systems.free_body.problem import FreeBody
from plumbob.analytic.systems.free_body.rotation import ANGULAR_VELOCITY_NAMES

ROTATION_SAMPLES = 257  # samples along the exact motion
ANY_GROWTH = 1e300  # allowed growth that only a diverged run exceeds
# multiple of the largest possible angular velocity: the run has diverged
DIVERGED_VELOCITY_FACTOR = 10.0
START_ATTITUDE = (1.0, 0.0, 0.0, 0.0)  # attitude at time 0


@dataclass(frozen=True)
class FreeRotationStability:
    """Step limits on the exact rotation of one body."""

    body: FreeBody

    @cached_property
    def motion(self) -> SmoothMotion:
        """The exact rotation with its equations of motion."""
        return free_rotation(self.body)

    @cached_property
    def _states(self) -> Array:
        """Angular velocities [rad/s] and attitudes along the motion, shape (7, n)."""
        longest = APERIODIC_PERIODS * math.tau / (self.body.speed or 1.0)
        return self.motion.state(
            np.linspace(0.0, min(2.0 * self.body.half_period, longest), ROTATION_SAMPLES)
        )

    @cached_property
    def rate(self) -> float:
        """The largest angular velocity of the motion [rad/s]."""
        return float(np.linalg.norm(self._states[:3], axis=0).max()) or 1.0

    @property
    def equilibrium(self) -> bool:
        """Whether the angular velocity is constant."""
        return self.body.kind == "steady"

    @cached_property
    def growth(self) -> FlowGrowth:
        """Growth of a nudge of the angular velocity, see `StabilityTheory`."""
        period = 2.0 * self.body.half_period
        repeats = math.isfinite(period)
        until = period if repeats else APERIODIC_PERIODS * math.tau / self.rate
        return growth_along(self.motion, np.ones(3), until, self.rate, repeats)

    def attitude_growth(self, duration: Any) -> Any:
        """Returns the growth of a nudge of angular velocity and attitude within a `duration` [s].

        The attitude integrates the angular velocity: it gains the nudge of the angular velocity
        once in each 1/rate.
        """
        return self.growth(duration) * (1.0 + self.rate * duration)

    def kind_of(self, observed: Signals) -> str:
        """Returns the axis about which the body turns, and the sense: "about the largest, +1".

        If the axis or the sense changes between samples, the kind is "irregular". If the exact
        rotation is steady or on the separatrix, the kind is always the exact one. If a rate is not
        finite, the kind is "lost".
        """
        if self.body.kind in ("steady", "separatrix"):
            return self.body.kind
        rates = np.stack([observed[name] for name in ANGULAR_VELOCITY_NAMES])
        if not np.isfinite(rates).all():
            return "lost"
        low, middle, high = np.argsort(self.body.inertia)
        moments = np.array(self.body.inertia)
        # |l|^2 less twice the energy times the middle moment is positive about the largest axis.
        about_largest = (moments * (moments - moments[middle])) @ rates**2 > 0.0
        if about_largest.all():
            axis, rate = "largest", rates[high]
        elif not about_largest.any():
            axis, rate = "smallest", rates[low]
        else:
            return "irregular"
        if (rate > 0.0).all() or (rate < 0.0).all():
            return f"about the {axis}, {np.sign(rate[0]):+.0f}"
        return "irregular"

    def limits(self, scheme: Scheme) -> tuple[StepLimit, ...]:
        """See `StabilityTheory`."""
        if scheme.integrator in (ADAPTIVE, CLOSED_FORM):
            return (NO_STEP,)
        if scheme.integrator not in SERIES_ORDERS or scheme.position_first:
            return ()
        if scheme.integrator == LEAPFROG:
            return self._by_iteration()
        motion = self._stepped_motion(scheme.integrator)
        return self._by_eigenvalues(motion) if self.equilibrium else limits_by_steps(motion)

    def energy(self, observed: Signals) -> Array:
        """Returns the energy over the exact motion's energy, see `StabilityTheory`."""
        return self.body.invariants(observed).get(
            "energy", np.zeros_like(observed[ANGULAR_VELOCITY_NAMES[0]])
        )

    def long_run(
        self, scheme: Scheme, step: float, scales: Mapping[str, float]
    ) -> LongRun | None:
        """See `StabilityTheory`."""
        errors = free_body_errors(self.body)
        exponent = 0.0 if self.equilibrium else float(self.growth.exponent)
        fastest = math.tau / self.rate
        series = partial(errors.series, scheme)
        return long_run_by_series(series, scales, step, fastest, exponent=exponent)

    def _by_iteration(self) -> tuple[StepLimit, ...]:
        """Returns the limit of leapfrog, whose implicit half step is solved by a fixed-point
        iteration.

        The iteration contracts up to a step of 2 over the largest rate of the linearised motion. At
        a smaller step the error that the iteration leaves may already drive the motion out of the
        range where it contracts: then that step is the limit. If the half step were solved exactly,
        leapfrog would have no limit.
        """
        fastest = float(np.abs(eigenvalues(self.motion, self._states, 3)).max())
        largest = 2.0 / fastest if fastest else math.inf
        if not self.equilibrium:
            diverged_only = replace(
                self._stepped_motion(LEAPFROG),
                growth=lambda times: np.full_like(times, ANY_GROWTH),
            )
            largest = min(largest, limits_near(diverged_only, largest, FIRST_PASS_RUN_STEPS)[0])
        why = "the implicit half step's fixed-point iteration no longer contracts at"
        return (step_limit("unstable", largest, why, self.rate),)

    def _by_eigenvalues(self, motion: SteppedMotion) -> tuple[StepLimit, ...]:
        """Returns the limits on a steady rotation.

        If the scheme steps the attitude as four numbers, their modes count too: their rates are
        half the angular velocity.
        """
        size = len(motion.begin(np.ones(1))[1])
        (rates,) = eigenvalues(self.motion, self._states[:, :1], size)

        def matrices(steps: Array) -> Array:
            """Returns the matrix of one step of each size in `steps` [s]."""
            return jacobians(*motion.begin(steps), len(steps))

        largest = largest_step(matrices, rates, self.rate)
        return (step_limit("unstable", largest, "the axis leaves its place at", self.rate),)

    def _stepped_motion(self, integrator: str) -> SteppedMotion:
        """Returns the rotation as an `integrator` steps it.

        The state includes the attitude only if the scheme steps its four numbers.
        """
        attitude = START_ATTITUDE if integrator in TABLEAUX else ()
        start = [*self.body.angular_velocity, *attitude]

        def begin(steps: Array) -> tuple[SchemeStep, StateParts]:
            """Returns the scheme's step for `steps` [s], shape (n,), and the initial state."""
            complex_steps = steps.astype(complex)  # spares a conversion in each operation
            return rotation_step(self.body, Scheme(integrator), complex_steps), start

        return SteppedMotion(
            begin=begin,
            names=ANGULAR_VELOCITY_NAMES,
            scales=(1.0, 1.0, 1.0),
            fastest=math.tau / self.rate,
            growth=self.growth,
            kind_of=self.kind_of,
            kind=self.kind_of(dict(zip(ANGULAR_VELOCITY_NAMES, self._states, strict=False))),
            window=0.0,
            lost=self._has_diverged,
        )

    def _has_diverged(self, state: StateParts) -> StableMarks:
        """Returns which runs have diverged, shape (n,).

        A run has diverged if the body turns DIVERGED_VELOCITY_FACTOR times faster than its energy
        allows, or if the four numbers of its attitude lengthen a vector by more than BAND."""
        angular_velocity = np.linalg.norm(np.real(state[:3]), axis=0)
        diverged = angular_velocity > DIVERGED_VELOCITY_FACTOR * self.body.fastest
        if len(state) > 3:
            diverged |= np.linalg.norm(state[3:], axis=0) ** 2 > BAND
        return np.asarray(diverged)


def free_rotation_stability(body: FreeBody) -> StabilityTheory:
    """Returns the stability theory of a free rigid body, see `FreeRotationStability`."""
    theory = FreeRotationStability(body)
    return StabilityTheory(
        fastest=math.tau / theory.rate,
        equilibrium=theory.equilibrium,
        limits=cache(theory.limits),
        growth=theory.attitude_growth,
        kind_of=theory.kind_of,
        long_run=theory.long_run,
        energy=theory.energy,
    )
