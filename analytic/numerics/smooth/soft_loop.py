"""Loops closed by soft constraints: a tree's equations with forces that close its gaps.

    M q'' = f + J^T l,   (J M^-1 J^T + R) l = -b J q' - k r - (J M^-1 f + J' q')                (1)

with k = 1/(d T^2), b = 2/(d T) and R = w (1 - d)/d, T the time constant, d the impedance, and w the
inverse mass that acts on a constraint (MuJoCo's documentation, Computation, "Constraint model").
MJX leaves out the term J' q'.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import SoftLoop

Gaps = Callable[[Any, Any, Any], tuple[Any, Any, Any]]
"""Function from parameters p, q and q' to the gaps r [m], shape (m,), their derivatives J, shape
(m, n), and J' q', shape (m,)."""


def softened(
    tree: SmoothSystem, gaps: Gaps, loop: SoftLoop, step: float, inverse_mass: float
) -> SmoothSystem:
    """Returns the `tree` with forces that close its `gaps` softly (eq. 1).

    `inverse_mass` is w [1/kg]. The time constant of the `loop` is at least two steps of `step` [s].
    """
    constant = max(loop.time_constant, 2 * step)
    damping = 2 / (loop.impedance * constant)
    stiffness = damping / (2 * constant)
    soft = inverse_mass * (1 - loop.impedance) / loop.impedance

    def forces(p: Any, time: Any, q: Any, v: Any) -> Any:
        at = (p, time, q, v)
        free, across, pull = _pulled(tree, gaps, at, damping, stiffness, soft, loop.curved)
        return (free + across.T @ pull).tolist()

    return replace(tree, forces=forces)


def loop_force(tree: SmoothSystem, gaps: Gaps, q: Array, v: Array) -> Array:
    """Returns the force [N] that keeps the `gaps` of a tree closed rigidly, shape (m,).

    It is l of eq. 1 without softness and gap. `q` and `v` are the tree's coordinates and rates,
    shape (n,) each.
    """
    return _pulled(tree, gaps, (tree.values, 0.0, q, v))[2]


def _pulled(
    tree: SmoothSystem,
    gaps: Gaps,
    at: tuple[Any, Any, Any, Any],
    damping: float = 0.0,
    stiffness: float = 0.0,
    soft: float = 0.0,
    curved: bool = True,
) -> tuple[Array, Array, Array]:
    """Returns f, J and l of eq. 1.

    `at` holds p, t, q and q'. `damping` is b, `stiffness` k and `soft` R. If the loop is not
    `curved`, the term J' q' is left out.
    """
    p, _, q, v = at
    mass: Array = np.array(tree.mass_matrix(p, q))
    free: Array = np.array(tree.forces(*at))
    gap, across, bent = (np.array(part) for part in gaps(p, q, v))
    light = np.linalg.solve(mass, across.T)
    wanted = -damping * (across @ np.array(v)) - stiffness * gap - light.T @ free
    if curved:
        wanted = wanted - bent
    return free, across, np.linalg.solve(across @ light + soft * np.eye(len(gap)), wanted)
