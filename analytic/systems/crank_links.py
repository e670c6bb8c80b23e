"""Mechanisms of one degree of freedom that a crank turns: their motion, from that of their links.

With the crank's angle t, and uniform links of mass m as vectors d(t) at the angles b(t), each from
the end of the one before, whose middles are at c(t), by Lagrange's equation (Landau and Lifshitz
1976, Mechanics, 5),

    J(t) t'' = -J'(t) t'^2/2 - g sum m c_y',   J = sum m (c' c' + d' d'/12)                     (1)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem

Pair = tuple[Any, Any]


class Link(NamedTuple):
    """A link's mass [kg] and d [m], with b' and b'' of eq. 1."""

    mass: Any
    vector: Pair
    turn: Any = 0.0
    turning: Any = 0.0


def _derivatives(links: Sequence[Link]) -> Iterator[tuple[Any, list[Any], list[Any]]]:
    """Of each link its mass, and x', y', x'' and y'' of c and of d/2."""
    end: list[Any] = [0.0] * 4
    for mass, (x, y), turn, turning in links:
        inward = turn**2
        slopes = -turn * y, turn * x, -turning * y - inward * x, turning * x - inward * y
        half = [slope / 2 for slope in slopes]
        yield mass, [a + b for a, b in zip(end, half, strict=True)], half
        end = [a + 2 * b for a, b in zip(end, half, strict=True)]


def _product(of: Sequence[Any], order: int) -> Any:
    """Of a first derivative with that of this order."""
    return of[0] * of[2 * order - 2] + of[1] * of[2 * order - 1]


def potential(gravity: float, links: Sequence[Link]) -> Any:
    """Potential energy [J] of `links` under `gravity` [m/s^2], 0 where they are level."""
    end, energy = 0.0, 0.0
    for mass, (_, rise), *_ in links:
        energy, end = energy + gravity * mass * (end + rise / 2), end + rise
    return energy


def crank_motion(
    problem: Any,
    constants: Sequence[str],
    links: Callable[[Any, Any], Sequence[Link]],
    readings: Callable[[Any, Any, Any], Mapping[str, Any]],
) -> CertifiedMotion:
    """The exact motion of `links`, of p and t, from a problem's `angle` [rad] and
    `angular_velocity` [rad/s]."""

    def summed(p: Any, q: Any, order: int) -> Any:
        """Of the products with c' and d'/2 of their derivatives of this order."""
        return sum(
            mass * (_product(middle, order) + _product(half, order) / 3)
            for mass, middle, half in _derivatives(links(p, q[0]))
        )

    def moment(p: Any, time: Any, q: Any, v: Any) -> tuple[Any]:
        weight = sum(mass * middle[1] for mass, middle, _ in _derivatives(links(p, q[0])))
        return (-summed(p, q, 2) * v[0] ** 2 - p.gravity * weight,)

    return CertifiedMotion(
        SmoothSystem(
            ("angle",),
            ("angle_dot",),
            lambda p, q: ((summed(p, q, 1),),),
            moment,
            {name: getattr(problem, name) for name in constants},
            (problem.angle,),
            (problem.angular_velocity,),
            readings=readings,
        )
    )
