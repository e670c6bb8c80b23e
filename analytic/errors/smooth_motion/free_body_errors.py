"""Errors of fixed steps on the rotation of a free rigid body (THEORY.md, 12).

Every scheme here takes the angular velocity w to Psi(w), whatever the attitude q, and q to q g(w).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

from plumbob.analytic.errors.smooth_motion.error_series import ErrorSeries, Step
from plumbob.analytic.numerics.smooth.smooth_system import solved
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import (
    EULER,
    LEAPFROG,
    LINEARLY_IMPLICIT,
    RK4_ADDED_RATES,
    TABLEAUX,
    Scheme,
)
from plumbob.analytic.systems.free_body.equations import (
    acceleration,
    factors,
    free_rotation,
    slope,
)
from plumbob.analytic.systems.free_body.problem import FreeBody
from plumbob.analytic.systems.free_body.rotation import ATTITUDE, RATES, product
from plumbob.analytic.tableau import CLASSICAL, along
from plumbob.analytic.theory import Coefficients, SteppedErrors

Numbers = Sequence[Any]  # parts of a vector, in any arithmetic
ORDERS: Mapping[str, range] = MappingProxyType(
    {EULER: range(1, 5), LINEARLY_IMPLICIT: range(1, 5), LEAPFROG: range(2, 10, 2)}
    | {RK4_ADDED_RATES: range(2, 7)}  # five, since the second is zero
    | {name: range(tableau.order, tableau.order + 4) for name, tableau in TABLEAUX.items()}
)
"""Of the errors of a scheme, that are followed."""


def kicked(of: Numbers, w: Numbers, at: Numbers, step: Any) -> list[Any]:
    """w + h f(`at`), f Euler's equations with the `factors` of a body."""
    return [x + step * force for x, force in zip(w, acceleration(of, at), strict=True)]


def linearly_implicit(of: Numbers, w: Numbers, step: Any) -> list[Any]:
    """w + h k, (1 - h J) k = f(w), J the derivative of f."""
    rows: list[list[Any]] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    for i, factor in enumerate(of):
        rows[i][i - 2], rows[i][i - 1] = -step * factor * w[i - 1], -step * factor * w[i - 2]
    slopes = solved(rows, acceleration(of, w))
    return [x + step * k for x, k in zip(w, slopes, strict=True)]


def _turned(of: Numbers, integrator: str, step: Any, w: Numbers) -> tuple[Numbers, Numbers]:
    """w after a step, a series, and the turn of the step: the attitude's is the exponential."""
    if integrator == RK4_ADDED_RATES:
        # The stages' angular velocities are added as vectors, and turn the body at once, although
        # each belongs to axes that have turned by then.
        after = CLASSICAL.advanced(
            lambda _, z: [*acceleration(of, z[:3]), *z[:3]], [*w, 0.0, 0.0, 0.0], along(step)
        )
        return after[:3], after[3:]
    if integrator == LEAPFROG:  # half a kick, explicit; a turn; half a kick, implicit
        turning = after = kicked(of, w, w, step / 2)
        for _ in step.terms:  # each time one degree more is right
            after = kicked(of, turning, after, step / 2)
    else:
        after = kicked(of, w, w, step) if integrator == EULER else linearly_implicit(of, w, step)
        turning = after
    return after, [step * x for x in turning]


def _exponential(turn: Numbers) -> Numbers:
    """The quaternion exp(turn/2), of a turn of first degree in its variable."""
    half = (0.0, *(x / 2 for x in turn))
    total: Numbers = (1.0, 0.0, 0.0, 0.0)
    term = total
    for k in range(1, len(turn[0].terms)):
        term = [x / k for x in product(term, half)]
        total = [x + y for x, y in zip(total, term, strict=True)]
    return total


@dataclass(frozen=True, eq=False)
class FreeBodyErrors:
    """The errors on one body's motion; an `ErrorTheory`."""

    body: FreeBody

    @cached_property
    def _series(self) -> ErrorSeries:
        of = factors(self.body)
        names = (*RATES, *ATTITUDE)
        return ErrorSeries(
            free_rotation(self.body), names, lambda time, state: slope(of, state), self._stepped
        )

    def _stepped(self, scheme: Scheme) -> tuple[Step, range] | None:
        integrator, of = scheme.integrator, factors(self.body)
        if integrator not in ORDERS or scheme.position_first:
            return None

        def step(time: Any, step: Any, state: Numbers) -> Numbers:
            if integrator in TABLEAUX:  # of w and q together: g is not of length 1
                tableau = TABLEAUX[integrator]
                return tableau.advanced(lambda _, z: slope(of, z), state, along(step))
            after, turn = _turned(of, integrator, step, state[:3])
            return [*after, *product(state[3:], _exponential(turn))]

        return step, ORDERS[integrator]

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """Coefficients of the error of each observable at `times` [s], shape (n,), by order."""
        return self._series.at(scheme, times)

    def at_step(self, scheme: Scheme, step: float, times: Array) -> SteppedErrors:
        """Empty: beyond the range of the series there is no prediction."""
        return SteppedErrors({})
