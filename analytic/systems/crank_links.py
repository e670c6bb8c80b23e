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

ComponentPair = tuple[Any, Any]


class CrankLink(NamedTuple):
    """A link's mass [kg] and vector d [m], and the derivatives b' (`turn`) and b'' (`turning`) of
    its angle by the crank's angle."""

    mass: Any
    vector: ComponentPair
    turn: Any = 0.0
    turning: Any = 0.0


class LinkDerivatives(NamedTuple):
    """A link's mass [kg], and the derivatives by the crank's angle of its middle c and of half its
    vector, d/2: x' and y', or x', y', x'' and y''."""

    mass: Any
    middle: Sequence[Any]
    half: Sequence[Any]


def _derivatives(links: Sequence[CrankLink], order: int) -> Iterator[LinkDerivatives]:
    """Yields the derivatives of each link, up to the `order` 1 or 2."""
    end: list[Any] = [0.0] * (2 * order)
    for mass, (x, y), turn, turning in links:
        x = x / 2
        y = y / 2
        half = [-turn * y, turn * x]
        if order == 2:
            inward = turn * turn
            half += [-turning * y - inward * x, turning * x - inward * y]
        middle = list(map(add, end, half))
        yield LinkDerivatives(mass, middle, half)
        end = list(map(add, middle, half))


def _sum_products(derivatives: Iterable[LinkDerivatives], order: int) -> Any:
    """Returns the sum of m (c'.c^(k) + d'.d^(k)/12) over the links, with k = `order`, the highest
    order of the `derivatives`."""

    def product(parts: Sequence[Any]) -> Any:
        """Returns the product of the first derivative and the one of the highest order."""
        return parts[0] * parts[2 * order - 2] + parts[1] * parts[2 * order - 1]

    return sum(
        mass * (product(middle) + product(half) / 3) for mass, middle, half in derivatives
    )


def potential(gravity: float, links: Sequence[CrankLink]) -> Any:
    """Returns the potential energy [J] of `links` under `gravity` [m/s^2]; it is 0 if all are
    level."""
    energy: Any = 0.0
    end: Any = 0.0  # height of the link's beginning
    for link in links:
        _, rise = link.vector
        energy = energy + gravity * link.mass * (end + rise / 2)
        end = end + rise
    return energy


def reaction(problem: Any, gaps: Gaps, times: Array) -> Array:
    """Returns the force [N] in the pin that closes a problem's opened chain, along the line and up,
    at `times` [s], shape (n,): shape (2, n). It is the multiplier of the constraint that closes the
    `gaps`."""
    states = problem.motion.observe(times)
    forces = []
    for angle, rate in zip(states["angle"], states["angle_dot"], strict=True):
        changed = replace(problem, angle=float(angle), angular_velocity=float(rate))
        chain = changed.open_chain
        forces.append(loop_force(chain, gaps, *np.split(chain.start, 2)))
    return np.array(forces).T


def crank_motion(
    problem: Any,
    constants: Sequence[str],
    links: Callable[[Any, Any], Sequence[CrankLink]],
    readings: Callable[[Any, Any, Any], Mapping[str, Any]],
) -> CertifiedMotion:
    """Returns the exact motion of a mechanism from a problem's `angle` [rad] and `angular_velocity`
    [rad/s]. `constants` are the names of its parameters. `links` returns the links from the
    parameters and the crank's angle; `readings` returns further observables."""

    def inertia(p: Any, q: Any) -> tuple[tuple[Any]]:
        """Returns J of eq. 1 as a mass matrix [kg m^2]."""
        derivatives = _derivatives(links(p, q[0]), 1)
        return ((_sum_products(derivatives, 1),),)

    def moment(p: Any, time: Any, q: Any, v: Any) -> tuple[Any]:
        """Returns the right-hand side of eq. 1 times J [N m]."""
        derivatives = [*_derivatives(links(p, q[0]), 2)]
        weight = sum(mass * middle[1] for mass, middle, _ in derivatives)
        return (-_sum_products(derivatives, 2) * v[0] ** 2 - p.gravity * weight,)

    return CertifiedMotion(
        SmoothSystem(
            coordinates=("angle",),
            rates=("angle_dot",),
            mass_matrix=inertia,
            forces=moment,
            parameters={name: getattr(problem, name) for name in constants},
            position=(problem.angle,),
            rate=(problem.angular_velocity,),
            readings=readings,
        )
    )
