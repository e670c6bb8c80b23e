"""One step of each scheme on a free rigid body, in power series in the step.

Every scheme here takes the angular velocity w to Psi(w), whatever the attitude q, and q to q g(w):
the angular velocity obeys an equation of its own, and q' = q w/2 is linear in q. A scheme is
therefore the pair Psi and g. Series have the degree along axis 0, then the component.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from plumbob.analytic.numerics.truncated_series import product, raised
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import (
    EULER,
    LEAPFROG,
    LINEARLY_IMPLICIT,
    RK4,
    RK4_ADDED_RATES,
    Scheme,
)

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


def rk4(body: Body, w: Array) -> tuple[Array, Array]:
    """The classical method on w and q together: g is its polynomial of q, not of length 1."""
    rates, after = _stages(body, w)
    identity, total = unit(w), np.zeros((len(w), 4, w.shape[2]))
    slope = np.zeros_like(identity)
    for rate, ahead, weight in zip(rates, (0.0, 0.5, 0.5, 1.0), (1, 2, 2, 1), strict=True):
        slope = quaternion_product(identity + ahead * raised(slope), _quaternion(rate)) / 2
        total += weight / 6 * slope
    return after, identity + raised(total)


def rk4_added_rates(body: Body, w: Array) -> tuple[Array, Array]:
    """The classical method for w; the angular velocities of its stages are added as vectors, and
    turn the body at once, although each belongs to axes that have turned by then."""
    (w1, w2, w3, w4), after = _stages(body, w)
    return after, _turned((w1 + 2 * (w2 + w3) + w4) / 6)


def _stages(body: Body, w: Array) -> tuple[tuple[Array, Array, Array, Array], Array]:
    """w at the stages, and after the step."""
    k1 = body.acceleration(w)
    w2 = w + raised(k1) / 2
    k2 = body.acceleration(w2)
    w3 = w + raised(k2) / 2
    k3 = body.acceleration(w3)
    w4 = w + raised(k3)
    k4 = body.acceleration(w4)
    return (w, w2, w3, w4), w + raised(k1 + 2 * (k2 + k3) + k4) / 6


def step_of(scheme: Scheme) -> tuple[Step, int] | None:
    """The step of a scheme on a free body and the order of its error; None where none is known."""
    if scheme.integrator == EULER and scheme.position_first:
        return None
    steps: tuple[tuple[str, Step, int], ...] = (
        (EULER, semi_implicit_euler, 1),
        (LINEARLY_IMPLICIT, linearly_implicit_euler, 1),
        (LEAPFROG, leapfrog, 2),
        (RK4_ADDED_RATES, rk4_added_rates, 2),
        (RK4, rk4, 4),
    )
    return next(((step, order) for name, step, order in steps if name == scheme.integrator), None)
