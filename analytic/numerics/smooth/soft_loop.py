"""Loops closed by soft constraints: a tree's equations with the forces that pull its gaps shut.

    M q'' = f + J^T l,   (J M^-1 J^T + R) l = -b J q' - k r - (J M^-1 f + J' q')                (1)

with k = 1/(d T^2), b = 2/(d T) and R = w (1 - d)/d, T the time constant, d the impedance, and w the
inverse mass that a constraint sees (MuJoCo's documentation, Computation, "Constraint model"). MJX
leaves out J' q'.
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


def softened(
    tree: SmoothSystem, gaps: Gaps, loop: SoftLoop, step: float, inverse_mass: float
) -> SmoothSystem:
    """The `tree` with its `gaps` shut softly (eq. 1): p, q, q' -> r [m], shape (m,), its
    derivatives J, shape (m, n), and J' q', shape (m,); of a body's `inverse_mass` w [1/kg]. The
    time constant is two steps [s] at least."""
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
    """The force [N] that keeps the `gaps` of a tree shut rigidly at its angles and rates, shape
    (n,) each: l of eq. 1 for no softness and no gap, shape (m,)."""
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
    """f, J and l of eq. 1 with these b, k and R, `at` p, t, q and q', and without J' q' unless the
    loop is `curved`."""
    p, _, q, v = at
    mass: Array = np.array(tree.mass_matrix(p, q))
    free: Array = np.array(tree.forces(*at))
    gap, across, bent = (np.array(part) for part in gaps(p, q, v))
    light = np.linalg.solve(mass, across.T)
    wanted = -damping * (across @ np.array(v)) - stiffness * gap - light.T @ free
    if curved:
        wanted = wanted - bent
    return free, across, np.linalg.solve(across @ light + soft * np.eye(len(gap)), wanted)
