"""Largest stable steps on the motion of any smooth system, by trial steps of many sizes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from plumbob.analytic.errors.smooth_motion.scheme_steps import SchemeStep, StateParts
from plumbob.analytic.errors.smooth_motion.stepped_system import system_step
from plumbob.analytic.errors.stability.flow_growth import (
    APERIODIC_PERIODS,
    FlowGrowth,
    eigenvalues,
    fastest_flow_rate,
    growth_along,
)
from plumbob.analytic.errors.stability.stepped_growth import SteppedMotion, limits_by_steps
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_motion import SmoothMotion, certified_smooth_motion
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.schemes import ADAPTIVE, LEAPFROG, Scheme
from plumbob.analytic.stability import NO_STEP, StabilityTheory, StepLimit

RATE_SAMPLES = 257  # samples of the exact motion that give its rates
RATE_SPAN = 2.0  # [s] duration of the exact motion that gives its rates
KIND_RATE_RATIO = 4.0  # chosen: ratio of root mean square rates beyond which the kind differs
# chosen: fraction of the fastest rate below which a coordinate is at rest
RESTING_RATE_FRACTION = 1e-3


@dataclass(frozen=True)
class SmoothStability:
    """Step limits on a `motion` whose coordinates are angles."""

    motion: CertifiedMotion

    @cached_property
    def exact(self) -> SmoothMotion:
        """The exact motion with its linearisation."""
        return certified_smooth_motion(self.motion)

    @cached_property
    def orbit(self) -> Array:
        """States of the exact motion, shape (2 n, RATE_SAMPLES)."""
        return self.exact.state(
            np.linspace(0.0, self.motion.known_until(RATE_SPAN), RATE_SAMPLES)
        )

    @cached_property
    def rate(self) -> float:
        """The fastest rate [rad/s] of the linearised motion, or of an angle that turns."""
        return fastest_flow_rate(
            eigenvalues(self.exact, self.orbit, len(self.orbit)), self.orbit
        )

    @property
    def scales(self) -> Array:
        """Units of the state, shape (2 n,): 1 rad for angles, the fastest rate for rates."""
        return np.repeat([1.0, self.rate], len(self.orbit) // 2)

    def kind_of(self, observed: Signals) -> str:
        """Returns "as fast", "slower" or "faster", see `StabilityTheory`.

        The rates in the last third of the samples are compared with the exact motion's rates. Each
        mean square is divided by the exact one, and the ratios are averaged. A motion is as fast if
        the root of the average is within a factor of KIND_RATE_RATIO.
        """
        _, exact_rates = np.split(self.orbit, 2)
        ratios = []
        for name, exact in zip(self.motion.system.rates, exact_rates, strict=True):
            exact_square = float(np.mean(exact**2))
            last_third = observed[name][-(len(observed[name]) + 2) // 3 :]
            if exact_square > (RESTING_RATE_FRACTION * self.rate) ** 2:
                ratios.append(float(np.mean(last_third**2)) / exact_square)
        ratio = math.sqrt(np.mean(ratios)) if ratios else 1.0
        if 1.0 / KIND_RATE_RATIO < ratio < KIND_RATE_RATIO:
            return "as fast"
        return "slower" if ratio < 1.0 else "faster"

    @cached_property
    def growth(self) -> FlowGrowth:
        """See `StabilityTheory`."""
        until = self.motion.known_until(APERIODIC_PERIODS * math.tau / self.rate)
        return growth_along(self.exact, self.scales, until, self.rate, repeats=False)

    def limits(self, scheme: Scheme) -> tuple[StepLimit, ...]:
        """Returns the limits of a scheme, see `StabilityTheory`.

        A scheme that chooses its steps has no limit. The limits are empty, which means not known,
        if a loop or a contact is soft, if no formula steps the scheme on this system, and for
        leapfrog, whose implicit half steps would take minutes."""
        if scheme.integrator == ADAPTIVE:
            return (NO_STEP,)
        system = self.motion.system
        soft = scheme.loop is not None or scheme.contact is not None
        if soft or scheme.integrator == LEAPFROG or system_step(scheme, system, 1.0) is None:
            return ()

        def begin(steps: Array) -> tuple[SchemeStep, StateParts]:
            """Returns the scheme's step for `steps` [s], shape (n,), and the initial state."""
            advance = system_step(scheme, system, steps)
            assert advance is not None
            return advance, system.start.tolist()

        motion = SteppedMotion(
            begin=begin,
            names=(*system.coordinates, *system.rates),
            scales=self.scales.tolist(),
            fastest=math.tau / self.rate,
            growth=self.growth,
            kind_of=self.kind_of,
            kind="as fast",
            window=RATE_SPAN,
        )
        return limits_by_steps(motion)


def smooth_stability(motion: CertifiedMotion) -> StabilityTheory:
    """Returns the stability theory of a smooth system, see `SmoothStability`."""
    theory = SmoothStability(motion)
    return StabilityTheory(
        fastest=math.tau / theory.rate,
        equilibrium=False,
        limits=cache(theory.limits),
        growth=theory.growth,
        kind_of=theory.kind_of,
    )
