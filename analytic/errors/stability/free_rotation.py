"""The largest steps on the exact rotation of a free rigid body.

Only the angular velocity is stepped: it knows nothing of the attitude, which follows it, and a
nudge of which stays what it is (THEORY.md, 12 and 13).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import Any

import numpy as np

from plumbob.analytic.errors.smooth_motion.free_body_errors import (
    ORDERS,
    free_body_errors,
    stepped,
)
from plumbob.analytic.errors.smooth_motion.scheme_steps import Advance, Parts
from plumbob.analytic.errors.stability.flow_growth import (
    PERIODS,
    FlowGrowth,
    eigenvalues,
    growth_along,
)
from plumbob.analytic.errors.stability.followed_runs import followed
from plumbob.analytic.errors.stability.largest_step import (
    Marks,
    jacobians,
    largest_step,
)
from plumbob.analytic.errors.stability.stepped_growth import (
    SHORT,
    SteppedMotion,
    limits_by_steps,
    near,
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
from plumbob.analytic.systems.free_body.rotation import RATES

SAMPLES = 257
ANY = 1e300  # growth that no nudge exceeds of a motion that is not lost
# times the largest angular velocity of the angular momentum: beyond, a run is lost
DIVERGED = 10.0
REST = (1.0, 0.0, 0.0, 0.0)  # the attitude at time 0


@dataclass(frozen=True)
class FreeRotationStability:
    """The limits on one body's exact rotation."""

    body: FreeBody

    @cached_property
    def motion(self) -> SmoothMotion:
        """The rotation with its equations."""
        return free_rotation(self.body)

    @cached_property
    def _states(self) -> Array:
        """Angular velocities [rad/s] and attitudes along the motion, shape (7, n)."""
        longest = PERIODS * math.tau / (self.body.speed or 1.0)
        return self.motion.state(
            np.linspace(0.0, min(2.0 * self.body.half_period, longest), SAMPLES)
        )

    @cached_property
    def rate(self) -> float:
        """The largest angular velocity of the motion [rad/s]."""
        return float(np.linalg.norm(self._states[:3], axis=0).max()) or 1.0

    @property
    def equilibrium(self) -> bool:
        """Whether the angular velocity stays what it is."""
        return self.body.kind == "steady"

    @cached_property
    def growth(self) -> FlowGrowth:
        """See `StabilityTheory`: of the angular velocity."""
        period = 2.0 * self.body.half_period
        repeats = math.isfinite(period)
        until = period if repeats else PERIODS * math.tau / self.rate
        return growth_along(self.motion, np.ones(3), until, self.rate, repeats)

    def grown(self, duration: Any) -> Any:
        """The growth of angular velocity and attitude together within a `duration` [s]: as much
        again each 1/rate of the attitude, which adds it up."""
        return self.growth(duration) * (1.0 + self.rate * duration)

    def kind_of(self, observed: Signals) -> str:
        """About which axis, and which side of it, the body turns in all samples; "irregular" where
        that changes, and the exact motion's kind where that is steady or on the separatrix."""
        if self.body.kind in ("steady", "separatrix"):
            return self.body.kind
        rates = np.stack([observed[name] for name in RATES])
        if not np.isfinite(rates).all():
            return "lost"
        low, middle, high = np.argsort(self.body.inertia)
        moments = np.array(self.body.inertia)
        parts = moments * (moments - moments[middle])
        about = parts @ rates**2 > 0.0  # |l|^2 less twice the energy times the middle moment
        if about.all() or not about.any():
            side = rates[high if about[0] else low]
            if (side > 0.0).all() or (side < 0.0).all():
                return f"about the {'largest' if about[0] else 'smallest'}, {np.sign(side[0]):+.0f}"
        return "irregular"

    def limits(self, scheme: Scheme) -> tuple[StepLimit, ...]:
        """See `StabilityTheory`."""
        if scheme.integrator in (ADAPTIVE, CLOSED_FORM):
            return (NO_STEP,)
        if scheme.integrator not in ORDERS or scheme.position_first:
            return ()
        if scheme.integrator == LEAPFROG:
            return self._by_iteration()
        motion = self._motion(scheme.integrator)
        return self._by_eigenvalues(motion) if self.equilibrium else limits_by_steps(motion)

    def energy(self, observed: Signals) -> Array:
        """See `StabilityTheory`: over that of the exact motion."""
        return self.body.invariants(observed).get("energy", np.zeros_like(observed[RATES[0]]))

    def long_run(
        self, scheme: Scheme, step: float, scales: Mapping[str, float]
    ) -> LongRun | None:
        """See `StabilityTheory`."""
        errors = free_body_errors(self.body)
        exponent = 0.0 if self.equilibrium else float(self.growth.exponent)
        fastest = math.tau / self.rate
        return followed(
            partial(errors.series, scheme), scales, step, fastest, exponent=exponent
        )

    def _by_iteration(self) -> tuple[StepLimit, ...]:
        """The step of which a half takes no part of the motion out of a fixed-point iteration's
        reach, 2 over the largest rate of the linearised motion (solved, leapfrog has no limit); or
        a smaller one at which what the iteration leaves drives the motion out of it."""
        fastest = float(np.abs(eigenvalues(self.motion, self._states, 3)).max())
        largest = 2.0 / fastest if fastest else math.inf
        if not self.equilibrium:
            lost_only = replace(
                self._motion(LEAPFROG), growth=lambda times: np.full_like(times, ANY)
            )
            largest = min(largest, near(lost_only, largest, SHORT)[0])
        why = "the implicit half step's fixed-point iteration no longer contracts at"
        return (step_limit("unstable", largest, why, self.rate),)

    def _by_eigenvalues(self, motion: SteppedMotion) -> tuple[StepLimit, ...]:
        """Limits of a steady rotation; where the scheme steps the attitude, too, of that as well,
        whose rates are half the angular velocity."""
        rates = eigenvalues(self.motion, self._states[:, :1], len(motion.begin(np.ones(1))[1]))[
            0
        ]
        largest = largest_step(
            lambda sizes: jacobians(*motion.begin(sizes), len(sizes)), rates, self.rate
        )
        return (step_limit("unstable", largest, "the axis leaves its place at", self.rate),)

    def _motion(self, integrator: str) -> SteppedMotion:
        """The motion in steps; with the attitude where the scheme steps its four numbers, too."""
        start = [*self.body.angular_velocity, *(REST if integrator in TABLEAUX else ())]

        def begin(sizes: Array) -> tuple[Advance, Parts]:
            complexes = sizes.astype(complex)  # numpy converts a real array in each operation
            return stepped(self.body, Scheme(integrator), complexes), start

        return SteppedMotion(
            begin,
            RATES,
            (1.0, 1.0, 1.0),
            math.tau / self.rate,
            self.growth,
            self.kind_of,
            self.kind_of(dict(zip(RATES, self._states, strict=False))),
            0.0,
            self._lost,
        )

    def _lost(self, state: Parts) -> Marks:
        """Where the body turns DIVERGED times faster than it can, or its attitude, four numbers,
        makes of a vector one that is BAND times as long."""
        lost = np.linalg.norm(np.real(state[:3]), axis=0) > DIVERGED * self.body.fastest
        if len(state) > 3:
            lost |= np.linalg.norm(state[3:], axis=0) ** 2 > BAND
        return np.asarray(lost)


def free_rotation_stability(body: FreeBody) -> StabilityTheory:
    """The theory of a free rigid body, see `FreeRotationStability`."""
    theory = FreeRotationStability(body)
    return StabilityTheory(
        math.tau / theory.rate,
        theory.equilibrium,
        cache(theory.limits),
        theory.grown,
        theory.kind_of,
        theory.long_run,
        theory.energy,
    )
