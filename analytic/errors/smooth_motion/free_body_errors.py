"""Errors of fixed steps on the rotation of a free rigid body (THEORY.md, 12).

Every scheme here takes the angular velocity w to Psi(w), which does not depend on the attitude q,
and takes q to the product q g(w).
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from plumbob.analytic.errors.smooth_motion.error_series import ErrorSeries, Step
from plumbob.analytic.errors.smooth_motion.scheme_steps import (
    Equations,
    SchemeStep,
    StateParts,
    scheme_step,
)
from plumbob.analytic.numerics.smooth.smooth_system import solve_linear
from plumbob.analytic.schemes import (
    EULER,
    LEAPFROG,
    LINEARLY_IMPLICIT,
    RK4,
    RK4_ADDED_RATES,
    TABLEAUX,
    Scheme,
)
from plumbob.analytic.systems.free_body.equations import (
    angular_acceleration,
    factors,
    free_rotation,
    slope,
)
from plumbob.analytic.systems.free_body.problem import FreeBody
from plumbob.analytic.systems.free_body.rotation import (
    ANGULAR_VELOCITY_NAMES,
    ATTITUDE,
    quaternion_product,
)
from plumbob.analytic.tableau import advance_parts

SERIES_ORDERS: Mapping[str, range] = MappingProxyType(
    {EULER: range(1, 5), LINEARLY_IMPLICIT: range(1, 5), LEAPFROG: range(2, 10, 2)}
    | {RK4_ADDED_RATES: range(2, 7)}  # five orders, because one of them is zero
    | {name: range(tableau.order, tableau.order + 4) for name, tableau in TABLEAUX.items()}
)
"""Orders of the error that are computed, by integrator."""


def rotation_step(body: FreeBody, scheme: Scheme, step: Any) -> SchemeStep:
    """Returns the step of a scheme of SERIES_ORDERS on the rotation of a body.

    A state is w [rad/s] and then q. A state may also be w alone, unless the scheme is one of
    TABLEAUX.
    """
    ratios = factors(body)
    integrator = scheme.integrator

    def forces(time: Any, q: StateParts, w: StateParts) -> StateParts:
        """Returns the derivative of w; for LINEARLY_IMPLICIT, the implicit slope."""
        if integrator == LINEARLY_IMPLICIT:
            return _implicit_slopes(ratios, w, step)
        return angular_acceleration(ratios, w)

    if integrator in TABLEAUX:  # w and q are stepped together, and |q| does not stay 1
        tableau = TABLEAUX[integrator]

        def explicit_step(time: Any, state: StateParts) -> StateParts:
            """Returns w and q after a step of an explicit Runge-Kutta method."""
            return tableau.advanced(lambda _, z: slope(ratios, z), state, step)

        return explicit_step
    if integrator == RK4_ADDED_RATES:
        # This scheme adds the angular velocities of its stages as vectors and turns the body by the
        # sum, although each stage belongs to axes that have turned meanwhile.
        classical_step = scheme_step(Scheme(RK4), Equations(forces, 3), step)

        def added_rates_step(time: Any, state: StateParts) -> StateParts:
            """Returns w and q after a step of RK4_ADDED_RATES."""
            after = classical_step(time, [0.0, 0.0, 0.0, *state[:3]])
            turn, rates = after[:3], after[3:]
            return [*rates, *_rotated(state[3:], turn, 1.0)]

        return added_rates_step
    base_scheme = Scheme(EULER) if integrator == LINEARLY_IMPLICIT else scheme
    rotate = _rotated_along_tangent if scheme.tangent_turn else _rotated
    base_step = scheme_step(base_scheme, Equations(forces, 3, None, rotate), step)

    def reordered_step(time: Any, state: StateParts) -> StateParts:
        """Returns w and q after a step of `base_step`, whose state is q and then w."""
        after = base_step(time, [*state[3:], *state[:3]])
        return [*after[-3:], *after[:-3]]

    return reordered_step


def _implicit_slopes(ratios: StateParts, w: StateParts, step: Any) -> StateParts:
    """Returns k of the linear system (1 - h J) k = f(w), with Euler's equations f and their
    Jacobian J."""
    rows: list[list[Any]] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    for i, ratio in enumerate(ratios):
        rows[i][i - 2] = -step * ratio * w[i - 1]
        rows[i][i - 1] = -step * ratio * w[i - 2]
    return solve_linear(rows, angular_acceleration(ratios, w))


def _rotated(q: StateParts, w: StateParts, step: Any) -> StateParts:
    """Returns q exp(h w/2), where the parts are power series in the step h."""
    if not len(q):
        return q
    half = (0.0, *[step * x / 2 for x in w])
    turn: StateParts = (1.0, 0.0, 0.0, 0.0)
    exponential_term = turn
    for k in range(1, len(half[1].terms)):
        exponential_term = [x / k for x in quaternion_product(exponential_term, half)]
        turn = advance_parts(turn, exponential_term, 1.0)
    return quaternion_product(q, turn)


def _rotated_along_tangent(q: StateParts, w: StateParts, step: Any) -> StateParts:
    """Returns q (1 + h w/2), normalised, where the parts are power series in the step h. The
    attitude q is turned by the angle 2 atan(|w| h/2)."""
    if not len(q):
        return q
    half = [step * x / 2 for x in w]
    square = half[0] * half[0] + half[1] * half[1] + half[2] * half[2]
    # The cosine of half the angle is 1/sqrt(1 + square), by its binomial series. The square begins
    # with h^2, so that its powers above half the number of terms have no term left.
    cosine = binomial_term = 1.0 + 0.0 * square
    for k in range(1, len(square.terms) // 2 + 1):
        binomial_term = binomial_term * square * (0.5 / k - 1.0)
        cosine = cosine + binomial_term
    return quaternion_product(q, [cosine, *(cosine * x for x in half)])


def free_body_errors(body: FreeBody) -> ErrorSeries:
    """Returns the error theory of one body's rotation."""

    ratios = factors(body)
    names = (*ANGULAR_VELOCITY_NAMES, *ATTITUDE)

    def step_and_orders(scheme: Scheme) -> tuple[Step, range] | None:
        """Returns the step of a scheme and the orders of its error; None without a series."""
        if scheme.integrator not in SERIES_ORDERS or scheme.position_first:
            return None

        def step(time: Any, length: Any, state: StateParts) -> StateParts:
            """Returns the state after a step of this `length` [s]."""
            return rotation_step(body, scheme, length)(time, state)

        return step, SERIES_ORDERS[scheme.integrator]

    def rates(time: Any, state: StateParts) -> StateParts:
        """Returns the derivatives of a state by time."""
        return slope(ratios, state)

    return ErrorSeries(free_rotation(body), names, rates, step_and_orders)
