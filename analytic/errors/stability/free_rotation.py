"""The largest steps on the exact rotation of a free rigid body.

Only the angular velocity is stepped: it knows nothing of the attitude, which follows it, and a
nudge of which stays what it is (THEORY.md, 12 and 13).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.errors.stability.flow_growth import LOST, PERIODS, FlowGrowth, flow_growth
from plumbob.analytic.errors.stability.largest_step import LEAST_PERIODS, largest_step
from plumbob.analytic.errors.stability.linear_steps import TINY, Complex, jacobians
from plumbob.analytic.errors.stability.stepped_growth import (
    SHORT,
    SteppedMotion,
    first_failures,
    near,
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
from plumbob.analytic.stability import BAND, NO_STEP, StabilityTheory, StepLimit
from plumbob.analytic.systems.free_body.problem import FreeBody
from plumbob.analytic.systems.free_body.rotation import RATES
from plumbob.analytic.tableau import Tableau, along, order_8

Rates = Sequence[Any]  # the three parts of an angular velocity [rad/s]
Begin = Callable[[Any], Callable[..., Rates]]  # of sizes of a step [s]: the step
SAMPLES = 257
STEPS = 40  # in a turn, of the method of order 8 that linearises the exact rotation: 1e-9
ANY = 1e300  # growth that no nudge exceeds of a motion that is not lost
CORRECTIONS = 100  # at most, of an implicit half step
DIVERGED = 10.0  # times the largest angular velocity of the angular momentum: beyond, a run is lost


@dataclass(frozen=True)
class RateSteps:
    """The schemes' steps of the angular velocity, for many sizes at once; `factors` are (I_j -
    I_k)/I_i of each axis."""

    factors: tuple[float, float, float]

    def slope(self, rates: Rates) -> list[Any]:
        """Its rate of change (Euler's equations)."""
        x, y, z = rates
        a, b, c = self.factors
        return [a * y * z, b * z * x, c * x * y]

    def jacobian(self, rates: Array) -> Array:
        """The slope's derivative, of one angular velocity, shape (3, 3)."""
        (a, b, c), (x, y, z) = self.factors, rates
        return np.array([[0.0, a * z, a * y], [b * z, 0.0, b * x], [c * y, c * x, 0.0]])

    def slopes(self, state: Rates) -> list[Any]:
        """The rates of change of the angular velocity and, where it belongs to the state, of the
        quaternion after it, of which q' = q w / 2."""
        x, y, z, *attitude = state
        if not attitude:
            return self.slope(state)
        d, a, b, c = (0.5 * part for part in attitude)
        turned = [-a * x - b * y - c * z, d * x + b * z - c * y, d * y + c * x - a * z]
        return [*self.slope((x, y, z)), *turned, d * z + a * y - b * x]

    def solved(self, rates: Rates, h: Any, right: Rates) -> list[Any]:
        """The solution of (1 - h J) s = right, J the slope's derivative."""
        (x, y, z), (a, b, c) = (h * part for part in rates), self.factors
        one = np.ones_like(x)
        rows = [[one, -a * z, -a * y], [-b * z, one, -b * x], [-c * y, -c * x, one]]
        system = np.moveaxis(np.array(rows), -1, 0)
        return list(np.linalg.solve(system, np.array(right).T[..., None])[..., 0].T)

    def euler(self, h: Any) -> Callable[..., Rates]:
        """w + h f(w)."""
        return lambda time, *w: [p + h * q for p, q in zip(w, self.slope(w), strict=True)]

    def linearly_implicit(self, h: Any) -> Callable[..., Rates]:
        """w + h k, (1 - h J) k = f(w)."""

        def advance(time: Any, *w: Any) -> Rates:
            slopes = self.solved(w, h, self.slope(w))
            return [p + h * q for p, q in zip(w, slopes, strict=True)]

        return advance

    def leapfrog(self, h: Any) -> Callable[..., Rates]:
        """Half a kick, explicit, and half a kick, implicit, by a fixed-point iteration that goes on
        while its changes shrink."""

        def advance(time: Any, *w: Any) -> Rates:
            kicked = np.array(w) + 0.5 * h * np.array(self.slope(w))
            rates, before, shrinks = kicked, np.inf, np.ones(kicked.shape[1:], dtype=bool)
            for _ in range(CORRECTIONS):
                corrected = kicked + 0.5 * h * np.array(self.slope(rates))
                change = np.abs(corrected - rates).max(axis=0)
                rates = np.where(shrinks, corrected, rates)
                shrinks &= (change > 0.0) & (change < before)
                if not shrinks.any():
                    break
                before = change
            return list(rates)

        return advance

    def explicit(self, tableau: Tableau) -> Begin:
        """A Runge-Kutta method."""

        def of_step(h: Any) -> Callable[..., Rates]:
            return lambda time, *state: tableau.advanced(
                lambda _, stage: self.slopes(stage), state, along(h)
            )

        return of_step

    def of(self, scheme: Scheme) -> Begin | None:
        """The step of a scheme by its size; None where none is known."""
        if scheme.integrator == EULER and not scheme.position_first:
            return self.euler
        if scheme.integrator == LINEARLY_IMPLICIT:
            return self.linearly_implicit
        if scheme.integrator == LEAPFROG:
            return self.leapfrog
        if scheme.integrator == RK4_ADDED_RATES:
            return self.explicit(TABLEAUX[RK4])
        tableau = TABLEAUX.get(scheme.integrator)
        return None if tableau is None else self.explicit(tableau)


@dataclass(frozen=True)
class FreeRotationStability:
    """The limits on one body's exact rotation."""

    body: FreeBody
    _found: dict[str, tuple[StepLimit, ...]] = field(default_factory=dict, repr=False)

    @property
    def _steps(self) -> RateSteps:
        x, y, z = self.body.inertia
        return RateSteps(((y - z) / x, (z - x) / y, (x - y) / z))

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
        advance = self._steps.explicit(order_8())(until / count)
        state = [
            np.full(3, w) + 1j * TINY * axis
            for w, axis in zip(self.body.angular_velocity, np.eye(3), strict=True)
        ]
        tangents = [np.eye(3)]
        for _ in range(count):
            state = list(advance(0.0, *state))
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
        begin = self._steps.of(scheme)
        if begin is None:
            return ()
        if scheme.integrator not in self._found:
            limits = self._by_eigenvalues if self.equilibrium else self._by_steps
            if scheme.integrator == LEAPFROG:
                limits = self._by_iteration
            self._found[scheme.integrator] = limits(begin, scheme.integrator in TABLEAUX)
        return self._found[scheme.integrator]

    def _by_iteration(self, begin: Begin, attitude: bool) -> tuple[StepLimit, ...]:
        """The step of which a half takes no part of the motion out of a fixed-point iteration's
        reach, 2 over the largest rate of the linearised motion (solved, leapfrog has no limit); or
        a smaller one at which what the iteration leaves drives the motion out of it."""
        jacobians_along = [self._steps.jacobian(rates) for rates in self._rates]
        largest = float(np.abs(np.linalg.eigvals(jacobians_along)).max())
        step = 2.0 / largest if largest else math.inf
        if not self.equilibrium:
            lost_only = replace(
                self._motion(begin, attitude), growth=lambda times: np.full_like(times, ANY)
            )
            step = min(step, near(lost_only, step, SHORT)[0])
        why = "the implicit half step's fixed-point iteration no longer contracts at"
        return (self._limit("unstable", step, why),)

    def _by_eigenvalues(self, begin: Begin, attitude: bool) -> tuple[StepLimit, ...]:
        """Limits of a steady rotation; with the `attitude` where the scheme steps it too, of which
        the rates are half the angular velocity."""
        state = self.body.angular_velocity
        rates: Complex = np.linalg.eigvals(self._steps.jacobian(np.array(state))).astype(complex)
        if attitude:
            state = (*state, 1.0, 0.0, 0.0, 0.0)
            rates = np.append(rates, np.array([0.5j, 0.5j, -0.5j, -0.5j]) * self.body.speed)
        step = largest_step(
            lambda steps: jacobians(begin(steps), state, len(steps)), rates, self.rate
        )
        return (self._limit("unstable", step, "the axis leaves its place at"),)

    def _by_steps(self, begin: Begin, attitude: bool) -> tuple[StepLimit, ...]:
        """Limits by stepping."""
        if float(self.growth(np.array(LEAST_PERIODS * math.tau / self.rate))) > LOST:
            return ()
        motion = self._motion(begin, attitude)
        unstable, changed = first_failures(motion)
        limits = []
        if not math.isnan(unstable):
            how = "a nudge grows a thousandfold too much at"
            limits.append(self._limit("unstable", unstable, how))
        if not changed >= 0.99 * unstable:
            why = f"the body no longer turns {motion.kind} at"
            limits.append(self._limit("changes-kind", changed, why))
        return tuple(limits)

    def _motion(self, begin: Begin, attitude: bool) -> SteppedMotion:
        """The motion in steps; with the `attitude` where the scheme steps its four numbers too."""
        start = self.body.angular_velocity
        nudge = 1j * TINY / 3**0.5

        def begun(steps: Array) -> tuple[Callable[..., Rates], Rates]:
            rates = [np.full(len(steps), w) + nudge for w in start]
            turned = [np.full(len(steps), w + 0j) for w in (1.0, 0.0, 0.0, 0.0)]
            return begin(steps), [*rates, *turned] if attitude else rates

        return SteppedMotion(
            begun,
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
            lost |= np.linalg.norm(np.real(state[3:]), axis=0) ** 2 > BAND
        return np.where(lost, np.inf, np.linalg.norm(nudged, axis=0) / TINY)

    def _limit(self, kind: Any, step: float, how: str) -> StepLimit:
        if math.isinf(step):
            return StepLimit(kind, step, "no step tried is too large")
        return StepLimit(kind, step, f"{how} h omega = {step * self.rate:.3g}, of the fastest turn")


def free_rotation_stability(body: FreeBody) -> StabilityTheory:
    """The theory of a free rigid body, see `FreeRotationStability`."""
    theory = FreeRotationStability(body)
    return StabilityTheory(
        math.tau / theory.rate, theory.equilibrium, theory.limits, theory.grown, theory.kind_of
    )
