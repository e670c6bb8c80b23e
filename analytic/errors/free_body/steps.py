"""One step of each scheme on a free rigid body, in power series in the step.

Every scheme here takes the angular velocity w to Psi(w), whatever the attitude q, and q to q g(w):
the angular velocity obeys an equation of its own, and q' = q w/2 is linear in q. A scheme is
therefore the pair Psi and g. Series have the degree along axis 0, then the component.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from plumbob.analytic.numerics.truncated_series import moved, product, raised
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import (
    EULER,
    LEAPFROG,
    LINEARLY_IMPLICIT,
    RK4_ADDED_RATES,
    TABLEAUX,
    Scheme,
)
from plumbob.analytic.tableau import CLASSICAL, Tableau

Step = Callable[["Body", Array], tuple[Array, Array]]
"""Body and w, shape (degrees, 3, n) -> Psi(w) and g, shape (degrees, 4, n)."""
_NEXT: Final = (1, 2, 0)
_LAST: Final = (2, 0, 1)


@dataclass(frozen=True)
class Body:
    """Coefficients of Euler's equations: (I_j - I_k)/I_i for each axis i, shape (3, 1)."""

    factors: Array

    @classmethod
    def of(cls, inertia: tuple[float, float, float]) -> Body:
        """The body with these moments [kg m^2]."""
        x, y, z = inertia
        return cls(np.array([[(y - z) / x], [(z - x) / y], [(x - y) / z]]))

    def acceleration(self, w: Array) -> Array:
        """w' of a series, shape (degrees, 3, n) (Euler's equations)."""
        return self.factors * product(w[:, _NEXT], w[:, _LAST])

    def linear(self, w: Array, v: Array) -> Array:
        """The derivative of `acceleration` at w along v, series both."""
        return self.factors * (
            product(w[:, _NEXT], v[:, _LAST]) + product(v[:, _NEXT], w[:, _LAST])
        )


def quaternion_product(p: Array, q: Array) -> Array:
    """Hamilton's product of series of quaternions, shape (degrees, 4, n) each."""
    a, b, c, d = np.moveaxis(p, 1, 0)
    w, x, y, z = np.moveaxis(q, 1, 0)
    return np.stack(
        [
            product(a, w) - product(b, x) - product(c, y) - product(d, z),
            product(a, x) + product(b, w) + product(c, z) - product(d, y),
            product(a, y) - product(b, z) + product(c, w) + product(d, x),
            product(a, z) + product(b, y) - product(c, x) + product(d, w),
        ],
        axis=1,
    )


def unit(like: Array) -> Array:
    """The series of the quaternion 1, for vectors of shape (degrees, 3, n)."""
    series = np.zeros((len(like), 4, like.shape[2]))
    series[0, 0] = 1.0
    return series


def _quaternion(w: Array) -> Array:
    return np.concatenate([np.zeros_like(w[:, :1]), w], axis=1)


def _turned(w: Array) -> Array:
    """g = exp(h w/2): a step at the angular velocity w, constant in the body."""
    half = raised(w) / 2
    square = product(half, half).sum(axis=1)
    cosine, ratio, power = np.zeros_like(square), np.zeros_like(square), np.zeros_like(square)
    power[0] = 1.0
    for k in range((len(w) + 1) // 2):
        cosine += power / math.factorial(2 * k)
        ratio += power / math.factorial(2 * k + 1)
        power = -product(power, square)
    return np.concatenate([cosine[:, None], product(half, ratio[:, None])], axis=1)


def semi_implicit_euler(body: Body, w: Array) -> tuple[Array, Array]:
    """The angular velocity first, then a turn at the new one."""
    after = w + raised(body.acceleration(w))
    return after, _turned(after)


def linearly_implicit_euler(body: Body, w: Array) -> tuple[Array, Array]:
    """(1 - h J) k = f(w), w + h k, then a turn at the new angular velocity."""
    force = body.acceleration(w)
    slope = force
    for _ in range(len(w)):  # each time one degree more is right
        slope = force + raised(body.linear(w, slope))
    after = w + raised(slope)
    return after, _turned(after)


def leapfrog(body: Body, w: Array) -> tuple[Array, Array]:
    """Half a kick, explicit; a turn; half a kick, implicit."""
    middle = w + raised(body.acceleration(w)) / 2
    after = middle
    for _ in range(len(w)):
        after = middle + raised(body.acceleration(after)) / 2
    return after, _turned(middle)


def runge_kutta(tableau: Tableau) -> Step:
    """A Runge-Kutta method on w and q together: g is its polynomial of q, not of length 1."""

    def step(body: Body, w: Array) -> tuple[Array, Array]:
        def slopes(fraction: float, state: Sequence[Array]) -> Sequence[Array]:
            rate, attitude = state
            return body.acceleration(rate), quaternion_product(attitude, _quaternion(rate)) / 2

        after, turn = tableau.advanced(slopes, (w, unit(w)), moved)
        return after, turn

    return step


def rk4_added_rates(body: Body, w: Array) -> tuple[Array, Array]:
    """The classical method for w; the angular velocities of its stages are added as vectors, and
    turn the body at once, although each belongs to axes that have turned by then."""

    def slopes(fraction: float, state: Sequence[Array]) -> Sequence[Array]:
        return body.acceleration(state[0]), state[0]

    start = (w, np.zeros_like(w))
    after, turned = CLASSICAL.slopes(slopes, start, moved)
    return moved(w, after, 1.0, CLASSICAL.divisor), _turned(turned / CLASSICAL.divisor)


def step_of(scheme: Scheme) -> tuple[Step, int] | None:
    """The step of a scheme on a free body and the order of its error; None where none is known."""
    if scheme.integrator == EULER and scheme.position_first:
        return None
    steps: tuple[tuple[str, Step, int], ...] = (
        (EULER, semi_implicit_euler, 1),
        (LINEARLY_IMPLICIT, linearly_implicit_euler, 1),
        (LEAPFROG, leapfrog, 2),
        (RK4_ADDED_RATES, rk4_added_rates, 2),
        *((name, runge_kutta(tableau), tableau.order) for name, tableau in TABLEAUX.items()),
    )
    return next(((step, order) for name, step, order in steps if name == scheme.integrator), None)
