"""The error of a fixed-step scheme on a free rigid body, as a power series in the step.

A step (Psi, g), see `steps`, is the exact flow over h of a modified equation, as formal series
(Hairer, Lubich and Wanner 2006, IX.1): with the shift E F(w, q) = F(Psi(w), q g(w)),

    h d/dt = log E = sum_k (-1)^(k+1)/k (E - 1)^k,

applied to w and q themselves. k steps in truncated series give it exactly. Its solution
w + h w_1 + h^2 w_2 + ... is found order by order, w_k' = J w_k + S_k(w, w_1 ... w_{k-1}), and the
attitude as p q with p = 1 + h p_1 + ... in the world's axes, a quadrature at each order:

    p' = p q (W - w) q*/2,    W the modified equation's angular velocity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from plumbob.analytic.errors.free_body.steps import (
    Body,
    Step,
    quaternion_product,
    step_of,
    unit,
)
from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.collocation import TimeGrid, gauss_collocation
from plumbob.analytic.numerics.linear_flow import LinearFlow, Response
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.systems.free_body.problem import FreeBody
from plumbob.analytic.systems.free_body.rotation import ATTITUDE, RATES, composed
from plumbob.analytic.theory import Coefficients, SteppedErrors

STAGES = 10  # Gauss nodes of a panel
LONGER = 1.1  # a series is followed to a power of this, further than the last time [s]
PANEL = 0.75  # [rad] that the body may turn in a panel
# Of a term, at a step in which the body turns by 1 rad, per radian of the motion: rounding makes up
# to a tenth of it where a term is zero, and what is taken for zero is below a step's own rounding.
ROUNDING = 16 * ULP
TERMS = 4  # of a series; five for those of even order, every other term of which may be zero


@dataclass(frozen=True)
class Panels:
    """Panels of Gauss nodes along an exact motion."""

    body: FreeBody
    until: float  # [s]

    @cached_property
    def grid(self) -> TimeGrid:
        """Where panels begin and end [s]."""
        count = max(1, math.ceil(self.until * self.body.fastest / PANEL))
        return TimeGrid(np.linspace(0.0, self.until, count + 1))

    @cached_property
    def state(self) -> tuple[Array, Array]:
        """Angular velocity, shape (3, nodes), and attitude, shape (4, nodes), at all nodes."""
        edges = self.grid.breakpoints
        times = edges[:-1, None] + edges[1] * gauss_collocation(STAGES).nodes
        return self.body.rotation.state(times.reshape(-1))

    @cached_property
    def _flow(self) -> LinearFlow:
        """w' = J w."""
        w = self.state[0].reshape(3, -1, STAGES)
        factors = Body.of(self.body.inertia).factors[:, 0]
        jacobian = np.zeros((*w.shape[1:], 3, 3))
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            jacobian[..., i, j], jacobian[..., i, k] = factors[i] * w[k], factors[i] * w[j]
        return LinearFlow(self.grid, jacobian)

    def respond(self, source: Array) -> Response:
        """The solution of w' = J w + S from 0, S of shape (3, nodes)."""
        return self._flow.respond(np.zeros((3, 1)), self._at_nodes(source))

    def integrate(self, source: Array) -> Response:
        """The integral from 0 of a source, shape (k, nodes)."""
        slopes, length = self._at_nodes(source), self.grid.breakpoints[1]
        across = length * np.einsum("m,pmij->pij", gauss_collocation(STAGES).weights, slopes)
        ends = np.cumsum(across, axis=0)
        return Response(self.grid, ends - across, ends[-1], slopes)

    def _at_nodes(self, source: Array) -> Array:
        panels = source.reshape(len(source), -1, STAGES)
        return np.moveaxis(panels, 0, -1)[..., None]


def _known(curve: Response, level: float) -> tuple[Response, Array]:
    """A curve, or zero where it never exceeds `level`, and its values at the nodes, (k, nodes)."""
    values = curve.at_nodes()
    if not np.abs(values).max() > level:
        zero = Response(curve.orbit, 0.0 * curve.starts, 0.0 * curve.end, 0.0 * curve.slopes)
        return zero, np.zeros((values.shape[2], values[..., 0, 0].size))
    return curve, values.reshape(-1, values.shape[2]).T


def modified_equation(step: Step, body: Body, w: Array) -> tuple[Array, Array]:
    """The modified equation's w', shape (degrees, 3, n), and half its angular velocity as a
    quaternion, shape (degrees, 4, n), at series w, shape (degrees, 3, n), to their degree."""
    steps = len(w)
    state = np.concatenate([w, np.zeros_like(w[:1])])  # one degree is lost to the division by h
    turned = unit(state)
    rates, turns = np.zeros_like(state), np.zeros_like(turned)
    for j in range(steps + 1):
        weight = sum((-1) ** (j + 1) * math.comb(k, j) / k for k in range(max(j, 1), steps + 1))
        rates, turns = rates + weight * state, turns + weight * turned
        if j < steps:
            state, turn = step(body, state)
            turned = quaternion_product(turned, turn)
    return rates[1:], turns[1:]


@dataclass(frozen=True)
class FreeBodyErrors:
    """The error series of one body's motion; an `ErrorTheory`."""

    body: FreeBody

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """Coefficients of the error of each observable at `times` [s], shape (n,), by order."""
        if step_of(scheme) is None:
            return {}
        last = float(np.max(times)) or 1.0
        until = LONGER ** math.ceil(math.log(last, LONGER))
        exact = self.body.rotation.state(times)[1]
        names = (*RATES, *ATTITUDE)
        return {
            order: dict(zip(names, (*_at(w, times), *composed(_at(p, times), exact)), strict=True))
            for order, w, p in _terms(self.body, scheme, until)
        }

    def at_step(self, scheme: Scheme, step: float, times: Array) -> SteppedErrors:
        """Empty: beyond the range of the series there is no prediction."""
        return SteppedErrors({})


def _at(curve: Response, times: Array) -> Array:
    """Values at `times` [s], shape (n,), as shape (k, n)."""
    return curve.at(times)[..., 0].T


def _drift(p: Array, defect: Array, k: int) -> Array:
    """Rate of p_k: the defects, composed with the errors of lower order."""
    return np.asarray(sum(composed(p[k - j], defect[j]) for j in range(1, k + 1)))


@lru_cache(maxsize=16)  # the same for all step sizes
def _terms(
    body: FreeBody, scheme: Scheme, until: float
) -> tuple[tuple[int, Response, Response], ...]:
    known = step_of(scheme)
    assert known is not None
    return expansion(Panels(body, until), *known)


def expansion(panels: Panels, step: Step, order: int) -> tuple[tuple[int, Response, Response], ...]:
    """Order, w_k in the body's axes and p_k in the world's, from the first that is not zero."""
    body = Body.of(panels.body.inertia)
    rates, attitude = panels.state
    conjugate = attitude * np.array([[1.0], [-1.0], [-1.0], [-1.0]])
    last = order + TERMS - (order != 2)
    w, p = np.zeros((last + 1, 3, rates.shape[1])), np.zeros((last + 1, 4, rates.shape[1]))
    w[0], p[0, 0] = rates, 1.0
    defect, terms = np.zeros_like(p), []
    for k in range(order, last + 1):
        source, turn = modified_equation(step, body, w[: k + 1])
        level = ROUNDING * panels.body.fastest**k * (1.0 + panels.body.fastest * panels.until)
        curve, w[k] = _known(panels.respond(source[k]), level * panels.body.fastest)
        turn[k, 1:] += w[k] / 2  # as w_k was not in the series yet
        defect[k] = composed(composed(attitude, turn[k]), conjugate)
        moved, p[k] = _known(panels.integrate(_drift(p, defect, k)), level)
        terms.append((k, curve, moved))
    return tuple(terms)


def free_body_errors(body: FreeBody) -> FreeBodyErrors:
    """The theory of a free rigid body."""
    return FreeBodyErrors(body)
