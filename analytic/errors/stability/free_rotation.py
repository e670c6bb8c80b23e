"""The largest steps on the exact rotation of a free rigid body.

Only the angular velocity is stepped: it knows nothing of the attitude, which follows it, and a
nudge of which stays what it is (THEORY.md, 12 and 13).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from plumbob.analytic.errors.smooth_motion.free_body_errors import FreeBodyErrors
from plumbob.analytic.errors.stability.flow_growth import PERIODS, FlowGrowth, flow_growth
from plumbob.analytic.errors.stability.followed_runs import FollowedMotion
from plumbob.analytic.errors.stability.largest_step import largest_step
from plumbob.analytic.errors.stability.linear_steps import (
    TINY,
    Complex,
    jacobians,
    stability_function,
)
from plumbob.analytic.errors.stability.stepped_growth import (
    SHORT,
    SteppedMotion,
    limits_by_steps,
    near,
    step_limit,
)
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import (
    ADAPTIVE,
    CLOSED_FORM,
    EULER,
    LEAPFROG,
    LINEARLY_IMPLICIT,
    RK4,
    RK4_ADDED_RATES,
    TABLEAUX,
    Scheme,
)
from plumbob.analytic.stability import BAND, NO_STEP, LongRun, StabilityTheory, StepLimit
from plumbob.analytic.systems.free_body.problem import FreeBody
from plumbob.analytic.systems.free_body.rotation import RATES
from plumbob.analytic.tableau import Moved, Tableau, along, order_8

NEXT, LAST = np.arange(3) - 2, np.arange(3) - 1  # of three axes
Rates = Sequence[Any]  # the three parts of an angular velocity [rad/s]
Step = Callable[..., Rates]
SAMPLES = 257
STEPS = 40  # in a turn, of the method of order 8 that linearises the exact rotation: 1e-9
ANY = 1e300  # growth that no nudge exceeds of a motion that is not lost
CORRECTIONS = 100  # at most, of an implicit half step
DIVERGED = 10.0  # times the largest angular velocity of the angular momentum: beyond, a run is lost


@dataclass(frozen=True)
class RateSteps:
    """The schemes' steps of the angular velocity, shape (3, n), and of the attitude after it, (5,
    n), for n sizes `h` [s] at once; `factors` are (I_j - I_k)/I_i of each axis. All are complex and
    of the same shape: numpy converts others each time."""

    factors: Any
    h: Any

    @cached_property
    def moved(self) -> Moved:
        """See `along`."""
        return along(self.h)

    def slope(self, rates: Any) -> Any:
        """Its rate of change (Euler's equations)."""
        return self.factors * rates.take(NEXT, 0) * rates.take(LAST, 0)

    def slopes(self, state: Any) -> Any:
        """The rates of change of the angular velocity and, where it belongs to the state, of the
        quaternion (d, a, b, c) after it, as d + ic and a + ib: q' = q w / 2."""
        if len(state) == 3:
            return self.slope(state)
        (first, second), slopes = state[3:], np.empty_like(state)
        slopes[:3] = self.slope(state[:3])
        half = 0.5 * state[:3]
        across, about = half[0] + 1j * half[1], 1j * half[2]
        slopes[3] = about * first - across.conj() * second
        slopes[4] = across * first - about * second
        return slopes

    def euler(self, time: Any, *w: Any) -> Any:
        """w + h f(w)."""
        rates = np.array(w)
        return rates + self.h * self.slope(rates)

    def linearly_implicit(self, time: Any, *w: Any) -> Any:
        """w + h k, (1 - h J) k = f(w), J the slope's derivative: by its adjugate."""
        rates = np.array(w)
        turned, factors = self.h * rates, self.factors
        change = self.slope(turned)
        across, pairs = turned + change, factors.take(NEXT, 0) * factors.take(LAST, 0)
        squares = pairs * turned * turned
        determinant = 1.0 - squares.sum(0) - 2.0 * factors.prod(0) * turned.prod(0)
        others = across.take(LAST, 0) * change.take(NEXT, 0)
        others += across.take(NEXT, 0) * change.take(LAST, 0)
        return rates + ((1.0 - squares) * change + factors * others) / (self.h * determinant)

    def leapfrog(self, time: Any, *w: Any) -> Any:
        """Half a kick, explicit, and half a kick, implicit, by a fixed-point iteration that goes on
        while its changes shrink."""
        half, start = 0.5 * self.h, np.array(w)
        kicked = start + half * self.slope(start)
        rates, before, shrinks = kicked, np.inf, np.ones(kicked.shape[1:], dtype=bool)
        for _ in range(CORRECTIONS):
            corrected = kicked + half * self.slope(rates)
            change = np.abs(corrected - rates).max(axis=0)
            rates = np.where(shrinks, corrected, rates)
            shrinks &= (change > 0.0) & (change < before)
            if not shrinks.any():
                break
            before = change
        return rates

    def explicit(self, tableau: Tableau, time: Any, *state: Any) -> Any:
        """A Runge-Kutta method."""
        one_part = (np.array(state),)
        return tableau.advanced(lambda _, stage: [self.slopes(*stage)], one_part, self.moved)[0]


def rate_step(scheme: Scheme) -> Step | None:
    """The step of a scheme, of `RateSteps`, a time and a state; None where none is known."""
    if scheme.integrator == EULER and not scheme.position_first:
        return RateSteps.euler
    if scheme.integrator == LINEARLY_IMPLICIT:
        return RateSteps.linearly_implicit
    if scheme.integrator == LEAPFROG:
        return RateSteps.leapfrog
    tableau = tableau_of(scheme)
    return None if tableau is None else lambda steps, *state: steps.explicit(tableau, *state)


def tableau_of(scheme: Scheme) -> Tableau | None:
    """The tableau by which a scheme steps the angular velocity; None where it has none."""
    if scheme.integrator == RK4_ADDED_RATES:
        return TABLEAUX[RK4]
    return TABLEAUX.get(scheme.integrator)


@dataclass(frozen=True)
class FreeRotationStability:
    """The limits on one body's exact rotation."""

    body: FreeBody
    _found: dict[str, tuple[StepLimit, ...]] = field(default_factory=dict, repr=False)

    @property
    def _factors(self) -> tuple[float, float, float]:
        x, y, z = self.body.inertia
        return (y - z) / x, (z - x) / y, (x - y) / z

    def _steps(self, sizes: Array, parts: int = 3) -> RateSteps:
        size = np.ones((parts, len(sizes)), dtype=complex)
        return RateSteps(size[:3] * np.array(self._factors)[:, None], size * sizes)

    def _jacobian(self, rates: Array) -> Array:
        """The derivative of Euler's equations at one angular velocity, shape (3, 3)."""
        (a, b, c), (x, y, z) = self._factors, rates
        return np.array([[0.0, a * z, a * y], [b * z, 0.0, b * x], [c * y, c * x, 0.0]])

    @cached_property
    def _rates(self) -> Array:
        """Angular velocities along the motion [rad/s], shape (n, 3)."""
        longest = PERIODS * math.tau / (self.body.speed or 1.0)
        until = min(2.0 * self.body.half_period, longest)
        return self.body.rotation.state(np.linspace(0.0, until, SAMPLES))[0].T

    @cached_property
    def rate(self) -> float:
        """The largest angular velocity of the motion [rad/s]."""
        return float(np.linalg.norm(self._rates, axis=1).max()) or 1.0

    @property
    def equilibrium(self) -> bool:
        """Whether the angular velocity stays what it is."""
        return self.body.kind == "steady"

    @cached_property
    def growth(self) -> FlowGrowth:
        """See `StabilityTheory`: of the angular velocity, and as much again each 1/rate of the
        attitude, which adds it up."""
        period = 2.0 * self.body.half_period
        until = period if math.isfinite(period) else PERIODS * math.tau / self.rate
        count = math.ceil(STEPS * until * self.rate / math.tau)
        steps, tableau = self._steps(np.full(3, until / count)), order_8()
        state = [
            np.full(3, w) + 1j * TINY * axis
            for w, axis in zip(self.body.angular_velocity, np.eye(3), strict=True)
        ]
        tangents = [np.eye(3)]
        for _ in range(count):
            state = list(steps.explicit(tableau, 0.0, *state))
            tangents.append(np.stack([part.imag / TINY for part in state]))
        times = np.linspace(0.0, until, count + 1)
        return flow_growth(times, np.array(tangents), math.isfinite(period))

    def grown(self, duration: float) -> float:
        """The growth of angular velocity and attitude together within a `duration` [s]."""
        return float(self.growth(np.array(duration))) * (1.0 + self.rate * duration)

    def kind_of(self, observed: Mapping[str, Array]) -> str:
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
        step = rate_step(scheme)
        if step is None:
            return ()
        if scheme.integrator not in self._found:
            stepped = TABLEAUX.get(scheme.integrator)
            if scheme.integrator == LEAPFROG:
                limits = self._by_iteration(step, stepped)
            elif self.equilibrium:
                limits = self._by_eigenvalues(step, stepped)
            else:
                limits = limits_by_steps(self._motion(step, stepped))
            self._found[scheme.integrator] = limits
        return self._found[scheme.integrator]

    def energy(self, observed: Mapping[str, Array]) -> Array:
        """See `StabilityTheory`: over that of the exact motion."""
        parts = zip(self.body.inertia, (observed[name] for name in RATES), strict=True)
        start = zip(self.body.inertia, self.body.angular_velocity, strict=True)
        scale = sum(moment * rate**2 for moment, rate in start) or 1.0
        return np.asarray(sum(moment * rates**2 for moment, rates in parts) / scale)

    def long_run(self, scheme: Scheme, step: float, scales: Mapping[str, float]) -> LongRun | None:
        """See `StabilityTheory`."""
        errors = FreeBodyErrors(self.body)
        exponent = 0.0 if self.equilibrium else float(self.growth.exponent)
        return FollowedMotion(
            partial(errors.series, scheme), scales, math.tau / self.rate, exponent=exponent
        ).long_run(step)

    def _by_iteration(self, step: Step, stepped: Tableau | None) -> tuple[StepLimit, ...]:
        """The step of which a half takes no part of the motion out of a fixed-point iteration's
        reach, 2 over the largest rate of the linearised motion (solved, leapfrog has no limit); or
        a smaller one at which what the iteration leaves drives the motion out of it."""
        jacobians_along = [self._jacobian(rates) for rates in self._rates]
        fastest = float(np.abs(np.linalg.eigvals(jacobians_along)).max())
        largest = 2.0 / fastest if fastest else math.inf
        if not self.equilibrium:
            lost_only = replace(
                self._motion(step, stepped),
                growth=lambda times: np.full_like(times, ANY),
                settles=True,
            )
            largest = min(largest, near(lost_only, largest, SHORT)[0])
        why = "the implicit half step's fixed-point iteration no longer contracts at"
        return (step_limit("unstable", largest, why, self.rate),)

    def _by_eigenvalues(self, step: Step, stepped: Tableau | None) -> tuple[StepLimit, ...]:
        """Limits of a steady rotation; where the scheme steps the attitude, too, of that as well,
        whose rates are half the angular velocity."""
        state = self.body.angular_velocity
        rates: Complex = np.linalg.eigvals(self._jacobian(np.array(state))).astype(complex)
        largest = largest_step(
            lambda sizes: jacobians(partial(step, self._steps(sizes)), state, len(sizes)),
            rates,
            self.rate,
        )
        if stepped is not None:
            half = np.array([0.5j * self.body.speed])
            attitude = largest_step(
                lambda sizes: stability_function(stepped, sizes[:, None, None] * half),
                half,
                self.rate,
            )
            largest = min(largest, attitude)
        return (step_limit("unstable", largest, "the axis leaves its place at", self.rate),)

    def _motion(self, step: Step, stepped: Tableau | None) -> SteppedMotion:
        """The motion in steps; with the attitude where the scheme steps its four numbers, too."""
        start = self.body.angular_velocity
        nudge = 1j * TINY / 3**0.5

        def begin(sizes: Array) -> tuple[Callable[..., Rates], Any]:
            begun = [w + nudge for w in start] + [1.0, 0.0j] * bool(stepped)
            steps = self._steps(sizes, len(begun))
            return partial(step, steps), np.multiply.outer(begun, np.ones(len(sizes)))

        return SteppedMotion(
            begin,
            self._nudge,
            lambda state: dict(zip(RATES, (part.real for part in state), strict=False)),
            math.tau / self.rate,
            self.growth,
            self.kind_of,
            self.kind_of(dict(zip(RATES, self._rates.T, strict=True))),
            0.0,
        )

    def _nudge(self, state: Rates) -> Array:
        """Size of a nudge, or infinity where the body turns DIVERGED times faster than it can, or
        its attitude, four numbers, makes of a vector one that is BAND times as long."""
        nudged, rates = (
            np.array([pick(part) for part in state[:3]]) for pick in (np.imag, np.real)
        )
        turning = np.linalg.norm(rates, axis=0)
        lost = turning > DIVERGED * self.body.fastest
        if len(state) > 3:
            lost |= np.linalg.norm(state[3:], axis=0) ** 2 > BAND
        return np.where(lost, np.inf, np.linalg.norm(nudged, axis=0) / TINY)


def free_rotation_stability(body: FreeBody) -> StabilityTheory:
    """The theory of a free rigid body, see `FreeRotationStability`."""
    theory = FreeRotationStability(body)
    return StabilityTheory(
        math.tau / theory.rate,
        theory.equilibrium,
        theory.limits,
        theory.grown,
        theory.kind_of,
        theory.long_run,
        theory.energy,
    )
