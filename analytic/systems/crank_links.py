"""Mechanisms of one degree of freedom that a crank turns: their motion from the motion of their
links.

The crank's angle is t. The links are uniform rods of mass m, the vectors d(t) at the angles b(t).
Each begins at the end of the one before; its middle is at c(t). By Lagrange's equation (Landau and
Lifshitz 1976, Mechanics, 5),

    J(t) t'' = -J'(t) t'^2/2 - g sum m c_y',   J = sum m (c' c' + d' d'/12)                     (1)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from operator import add
from typing import Any, NamedTuple

import numpy as np

from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.numerics.smooth.soft_loop import Gaps, loop_force
from plumbob.analytic.reference import Array

Pair = tuple[Any, Any]
Moved = tuple[Any, Sequence[Any], Sequence[Any]]


class Link(NamedTuple):
    """A link's mass [kg] and vector d [m], and the derivatives b' (`turn`) and b'' (`turning`) of
    its angle by the crank's angle."""

    mass: Any
    vector: Pair
    turn: Any = 0.0
    turning: Any = 0.0


def _derivatives(links: Sequence[Link], order: int) -> Iterator[Moved]:
    """Yields for each link its mass, and the lists of x' and y' of c and of d/2. If `order` is 2,
    the lists also hold x'' and y''."""
    end: list[Any] = [0.0] * (2 * order)
    for mass, (x, y), turn, turning in links:
        x = x / 2
        y = y / 2
        inward = turn * turn
        half = [-turn * y, turn * x]
        if order == 2:
            half += [-turning * y - inward * x, turning * x - inward * y]
        middle = list(map(add, end, half))
        yield mass, middle, half
        end = list(map(add, middle, half))


def _summed(moved: Iterable[Moved], order: int) -> Any:
    """Returns the sum of m (c'.c^(order) + d'.d^(order)/12), with the derivatives of this
    `order`."""

    def product(of: Sequence[Any]) -> Any:
        return of[0] * of[2 * order - 2] + of[1] * of[2 * order - 1]

    return sum(mass * (product(middle) + product(half) / 3) for mass, middle, half in moved)


def potential(gravity: float, links: Sequence[Link]) -> Any:
    """Returns the potential energy [J] of `links` under `gravity` [m/s^2]; it is 0 if all are
    level."""
    end, energy = 0.0, 0.0
    for mass, (_, rise), *_ in links:
        energy = energy + gravity * mass * (end + rise / 2)
        end = end + rise
    return energy


def reaction(problem: Any, gaps: Gaps, times: Array) -> Array:
    """Returns the force [N] in the pin that closes a problem's opened chain, along the line and up,
    at `times` [s], shape (n,): shape (2, n). It is the multiplier of the constraint `gaps`."""
    states = problem.motion.observe(times)
    cranks = zip(states["angle"].tolist(), states["angle_dot"].tolist(), strict=True)
    chains = (replace(problem, angle=t, angular_velocity=v).opened for t, v in cranks)
    return np.array([loop_force(at, gaps, *np.split(at.start, 2)) for at in chains]).T


def crank_motion(
    problem: Any,
    constants: Sequence[str],
    links: Callable[[Any, Any], Sequence[Link]],
    readings: Callable[[Any, Any, Any], Mapping[str, Any]],
) -> CertifiedMotion:
    """Returns the exact motion of a mechanism from a problem's `angle` [rad] and `angular_velocity`
    [rad/s]. `links` returns the links from the parameters and the crank's angle."""

    def inertia(p: Any, q: Any) -> tuple[tuple[Any]]:
        return ((_summed(_derivatives(links(p, q[0]), 1), 1),),)

    def moment(p: Any, time: Any, q: Any, v: Any) -> tuple[Any]:
        moved = [*_derivatives(links(p, q[0]), 2)]
        weight = sum(mass * middle[1] for mass, middle, _ in moved)
        return (-_summed(moved, 2) * v[0] ** 2 - p.gravity * weight,)

    return CertifiedMotion(
        SmoothSystem(
            ("angle",),
            ("angle_dot",),
            inertia,
            moment,
            {name: getattr(problem, name) for name in constants},
            (problem.angle,),
            (problem.angular_velocity,),
            readings=readings,
        )
    )
