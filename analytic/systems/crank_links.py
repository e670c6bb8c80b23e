"""Mechanisms of one degree of freedom that a crank turns: their motion, from that of their links.

With the crank's angle t, and of each uniform link the mass m, the length l, the centre c(t) and the
angle b(t), by Lagrange's equation (Landau and Lifshitz 1976, Mechanics, 5),

    J(t) t'' = -J'(t) t'^2/2 - g sum m c_y',   J = sum m (c' c' + l^2 b'^2/12)                  (1)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.parameters import finite, non_negative, positive

Pair = tuple[Any, ...]


class Link(NamedTuple):
    """A link's mass [kg] and length [m], with c', c'', b' and b'' of eq. 1."""

    mass: Any
    length: Any
    slope: Pair
    bend: Pair
    turn: Any = 0.0
    turning: Any = 0.0


def dot(a: Pair, b: Pair) -> Any:
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1]


def cross(a: Pair, b: Pair) -> Any:
    """The vector product's third component."""
    return a[0] * b[1] - a[1] * b[0]


def check_constants(problem: Any, constants: Sequence[str], start: Sequence[str]) -> None:
    """Raise ParameterError where one of a problem's `constants` is not positive, the last of them,
    its gravity, is negative, or a parameter of the `start` is not finite."""
    for name in (*constants, *start):
        check = finite if name in start else positive
        (non_negative if name == constants[-1] else check)(name, getattr(problem, name))


def crank_motion(
    problem: Any,
    constants: Sequence[str],
    links: Callable[[Any, Any], Sequence[Link]],
    readings: Callable[[Any, Any, Any], Mapping[str, Any]],
) -> CertifiedMotion:
    """The exact motion of `links`, of p and t, from a problem's `angle` [rad] and
    `angular_velocity` [rad/s]."""

    def inertia(p: Any, q: Any) -> tuple[tuple[Any]]:
        parts = (
            link.mass * (dot(link.slope, link.slope) + (link.length * link.turn) ** 2 / 12)
            for link in links(p, q[0])
        )
        return ((sum(parts),),)

    def moment(p: Any, time: Any, q: Any, v: Any) -> tuple[Any]:
        half, weight = 0.0, 0.0
        for link in links(p, q[0]):
            turned = link.length**2 * link.turn * link.turning / 12
            half = half + link.mass * (dot(link.slope, link.bend) + turned)
            weight = weight + link.mass * link.slope[1]
        return (-half * v[0] ** 2 - p.gravity * weight,)

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
