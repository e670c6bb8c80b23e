"""Largest stable steps on a pendulum's exact motion, by eigenvalues or by trial steps."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial

import numpy as np

from plumbob.analytic.errors.smooth_motion.rotor_errors import RotorErrors
from plumbob.analytic.errors.smooth_motion.stepped_rotor import many_steps, simplest_scheme
from plumbob.analytic.errors.stability.flow_growth import (
    APERIODIC_PERIODS,
    FlowGrowth,
    eigenvalues,
    fastest_flow_rate,
    growth_along,
)
from plumbob.analytic.errors.stability.followed_runs import long_run_by_series
from plumbob.analytic.errors.stability.largest_step import (
    EigenvalueRates,
    jacobians,
    largest_lasting_step,
    largest_step,
)
from plumbob.analytic.errors.stability.long_runs import PeriodicMotion, kinetic_energy
from plumbob.analytic.errors.stability.pendulum_kinds import JUDGED_KINDS, PendulumKinds
from plumbob.analytic.errors.stability.stepped_growth import (
    SteppedMotion,
    limits_by_steps,
    step_limit,
)
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.orbit import ANGLE_AND_RATE
from plumbob.analytic.numerics.smooth.smooth_system import IMAGINARY_STEP
from plumbob.analytic.reference import Array, Reference, Signals
from plumbob.analytic.schemes import ADAPTIVE, CLOSED_FORM, STEPPED_SCHEMES, Scheme
from plumbob.analytic.stability import LEVELS, NO_STEP, LongRun, StabilityTheory, StepLimit

# Largest relative change of the potential's curvature along a motion that counts as small.
SMALL_CURVATURE_CHANGE = 1e-3
ORBIT_SAMPLES = 512  # samples of the orbit
# time constants after which a damped motion is at rest, or a forced one repeats
SETTLING_TIME_CONSTANTS = 10.0
# Growth of a nudge in a period above which the motion passes close to a saddle. The time ahead of
# (13.7) is linear in the error and does not describe such a motion.
SADDLE_PASSAGE_GROWTH = 30.0


@dataclass(frozen=True)
class PendulumStability:
    """Step limits on the `exact` motion of a `rotor`.

    `start` is theta [rad] and theta_dot [rad/s] at time 0. `period` [s] is infinite if the motion
    has none.
    """

    rotor: DrivenRotor
    start: tuple[float, float]
    exact: Reference
    period: float = math.inf

    @cached_property
    def errors(self) -> RotorErrors:
        """Error theory of the motion."""
        return RotorErrors(self.rotor, *self.start, self.exact)

    @cached_property
    def _span(self) -> float:
        """Time span [s] that is sampled: one period, or APERIODIC_PERIODS of the fastest mode."""
        if math.isfinite(self.period):
            return self.period
        return APERIODIC_PERIODS * math.tau / (self.rotor.rate() or 1.0)

    @cached_property
    def _orbit(self) -> Array:
        """Samples of theta [rad] and theta_dot [rad/s] along the time span, shape (2,
        ORBIT_SAMPLES)."""
        return self.errors.motion.state(np.linspace(0.0, self._span, ORBIT_SAMPLES))

    @cached_property
    def _rates(self) -> EigenvalueRates:
        """Eigenvalues of the linearised motion along the orbit [1/s], shape (n, 2)."""
        return eigenvalues(self.errors.motion, self._orbit, 2)

    @cached_property
    def rate(self) -> float:
        """The fastest angular frequency or rate [rad/s] of the linearised motion."""
        # A linear rotor's angle has no period of 2 pi: its turns set no rate.
        return fastest_flow_rate(self._rates, self._orbit * (not self.rotor.linear))

    @cached_property
    def equilibrium(self) -> bool:
        """Whether eigenvalues alone set the limits.

        Eigenvalues suffice if the rotor is linear, or if it stays so close to an equilibrium that
        the curvature of its potential is constant.
        """
        theta = self._orbit[0]
        curvature = self.rotor.slope(theta)
        constant_curvature = (
            np.ptp(curvature) <= SMALL_CURVATURE_CHANGE * np.abs(curvature).max()
        )
        bounded = math.isfinite(self.period) or self.rotor.damping_rate or not np.ptp(theta)
        stays_close = bounded and constant_curvature and self.rotor.autonomous
        return bool(self.rotor.linear or stays_close)

    @cached_property
    def growth(self) -> FlowGrowth:
        """See `StabilityTheory`."""
        scales = np.array([1.0, self.rate])
        repeats = math.isfinite(self.period)
        return growth_along(self.errors.motion, scales, self._span, self.rate, repeats)

    @cached_property
    def kinds(self) -> PendulumKinds:
        """Classifier of the rotor's motions."""
        return PendulumKinds(self.rotor, float(np.abs(self._orbit[1]).max()))

    @cached_property
    def kind(self) -> str:
        """The exact motion's kind."""
        spans = 20.0 if math.isfinite(self.period) else 1.0
        times = np.linspace(0.0, spans * self._span, ORBIT_SAMPLES)
        return self.kinds(self.exact.observe(times))

    def kind_of(self, observed: Signals) -> str:
        """Returns the kind of motion, see `StabilityTheory`; if the exact motion's kind is not
        judged, always the exact motion's kind."""
        return self.kinds(observed) if self.kind.startswith(JUDGED_KINDS) else self.kind

    def limits(self, scheme: Scheme) -> tuple[StepLimit, ...]:
        """See `StabilityTheory`."""
        if scheme.integrator in (ADAPTIVE, CLOSED_FORM):
            return (NO_STEP,)
        jointed = scheme.joint_closing_rate is not None
        if scheme.integrator not in STEPPED_SCHEMES or (jointed and not self.rotor.sin):
            return ()
        return self._cached_limits(simplest_scheme(scheme, self.rotor))

    @cached_property
    def _cached_limits(self) -> Callable[[Scheme], tuple[StepLimit, ...]]:
        """Function from a scheme to its limits, which caches them."""
        return cache(self._by_eigenvalues if self.equilibrium else self._by_steps)

    @cached_property
    def repeats_after(self) -> float:
        """Period [s] of an undamped motion, linear or not; infinite if there is none."""
        linear = self.rotor.linear and self.rotor.conservative and self.rotor.stiffness > 0.0
        return math.tau / math.sqrt(self.rotor.stiffness) if linear else self.period

    @cached_property
    def lasts(self) -> float:
        """Time [s] until a damped motion is at rest: SETTLING_TIME_CONSTANTS time constants of the
        mode with the least damping, see `StabilityTheory`."""
        if not self.rotor.damping_rate or self.growth.exponent:
            return math.inf
        least_damping = float(np.abs(self._rates.real).min())
        return SETTLING_TIME_CONSTANTS / max(least_damping, IMAGINARY_STEP)

    def energy(self, observed: Signals) -> Array:
        """Returns the ratio of the energy to the largest kinetic energy of the exact motion, see
        `StabilityTheory`."""
        scale = kinetic_energy(self.exact, self._span)
        return self.rotor.energy(observed["theta"], observed["theta_dot"]) / scale

    def long_run(
        self, scheme: Scheme, step: float, scales: Mapping[str, float]
    ) -> LongRun | None:
        """See `StabilityTheory`."""
        growth_in_period = self.growth.largest[-1] if math.isfinite(self.period) else 0.0
        passes_saddle = growth_in_period > SADDLE_PASSAGE_GROWTH
        if self.rotor.conservative and math.isfinite(self.repeats_after) and not passes_saddle:
            motion = PeriodicMotion(self.errors, self.repeats_after)
            return motion.long_run(scheme, step, scales["theta"])
        run = long_run_by_series(
            series=partial(self.errors.series, scheme),
            scales=scales,
            step=step,
            fastest=math.tau / self.rate,
            lasts=self.lasts,
            exponent=float(self.growth.exponent),
        )
        if passes_saddle and run and run.times[LEVELS[0]] < self.period:
            exponent = math.log(float(self.growth.largest[-1])) / self.period
            return replace(run, growth="exponential", rate=exponent)
        return run

    def _by_eigenvalues(self, scheme: Scheme) -> tuple[StepLimit, ...]:
        """Returns the limits of a scheme on a motion near an equilibrium."""
        # The steps are linearised at the middle of the swing, which is at the equilibrium.
        middle = (float(np.mean(self._orbit[0])), 0.0)

        def matrices(steps: Array) -> Array:
            """Returns the matrix of one step of each size in `steps` [s]."""
            return jacobians(*many_steps(self.rotor, middle, scheme, steps), len(steps))

        rates = self._rates[-1]
        step = largest_step(matrices, rates)
        limits = [step_limit("unstable", step, "of", self.rate)]
        if self.rotor.conservative and np.ptp(self._orbit[0]):
            lasting = largest_lasting_step(matrices, rates)
            if lasting < step:
                limits.append(step_limit("changes-kind", lasting, "damps", self.rate))
        return tuple(limits)

    def _by_steps(self, scheme: Scheme) -> tuple[StepLimit, ...]:
        """Returns the limits of a scheme on any motion: steps of many sizes are tried, and the
        growth of a nudge and the kind of the stepped motion show which of them hold."""
        scales = [1.0, self.rate]
        if scheme.joint_closing_rate is not None:
            # the speed of a jointed bob is a further part of the state
            scales.append(self.rate)
        # A run shows its kind in two periods or, without a period, in the time span of the orbit.
        spans = 2.0 if math.isfinite(self.period) else 1.0
        motion = SteppedMotion(
            begin=partial(many_steps, self.rotor, self.start, scheme),
            names=ANGLE_AND_RATE,
            scales=scales,
            fastest=math.tau / self.rate,
            growth=self.growth,
            kind_of=self.kind_of,
            kind=self.kind,
            window=self._span * spans,
        )
        return limits_by_steps(motion)


def pendulum_stability(
    rotor: DrivenRotor,
    start: tuple[float, float],
    exact: Reference,
    period: float,
    tilt: float = 0.0,
) -> StabilityTheory:
    """Returns the stability theory of a pendulum, see `PendulumStability`.

    `tilt` [rad] is the rotor's angle less the observed theta.
    """
    theory = PendulumStability(rotor, start, exact, period)

    def with_rotor_angle(observed: Signals) -> Signals:
        """Returns the observables with the rotor's angle as theta."""
        return {**observed, "theta": observed["theta"] + tilt}

    def energy(observed: Signals) -> Array:
        """Returns the ratio of the energy to its scale."""
        return theory.energy(with_rotor_angle(observed))

    return StabilityTheory(
        fastest=math.tau / theory.rate,
        equilibrium=theory.equilibrium,
        limits=theory.limits,
        growth=theory.growth,
        kind_of=lambda observed: theory.kind_of(with_rotor_angle(observed)),
        long_run=theory.long_run,
        energy=energy if rotor.conservative else None,
        lasts=theory.lasts,
    )
