"""Mechanisms of one degree of freedom that a crank turns: their motion, from that of their links.

With the crank's angle t, and uniform links of mass m as vectors d(t) at the angles b(t), each from
the end of the one before, whose middles are at c(t), by Lagrange's equation (Landau and Lifshitz
1976, Mechanics, 5),

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
    """A link's mass [kg] and d [m], with b' and b'' of eq. 1."""

    mass: Any
    vector: Pair
    turn: Any = 0.0
    turning: Any = 0.0


def _derivatives(links: Sequence[Link], order: int) -> Iterator[Moved]:
    """Of each link its mass, and x' and y' of c and of d/2, with x'' and y'' where the `order` is
    2."""
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
    """Sum of the products of c' and d'/2 with their derivatives of this order, by mass."""

    def product(of: Sequence[Any]) -> Any:
        return of[0] * of[2 * order - 2] + of[1] * of[2 * order - 1]

    return sum(mass * (product(middle) + product(half) / 3) for mass, middle, half in moved)


def potential(gravity: float, links: Sequence[Link]) -> Any:
    """Potential energy [J] of `links` under `gravity` [m/s^2], 0 where they are level."""
    end, energy = 0.0, 0.0
    for mass, (_, rise), *_ in links:
        energy = energy + gravity * mass * (end + rise / 2)
        end = end + rise
    return energy


def reaction(problem: Any, gaps: Gaps, times: Array) -> Array:
    """Force [N] in the pin that ties a problem's opened chain, along the line and up, at `times`
    [s], shape (n,), by the multipliers of its `gaps`; shape (2, n)."""
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
    """The exact motion of `links`, of p and t, from a problem's `angle` [rad] and
    `angular_velocity` [rad/s]."""

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
