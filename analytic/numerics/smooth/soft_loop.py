"""Loops closed by soft constraints: a tree's equations with forces that close its gaps.

    M q'' = f + J^T l,   (J M^-1 J^T + R) l = -b J q' - k r - (J M^-1 f + J' q')                (1)

with k = 1/(d T^2), b = 2/(d T) and R = w (1 - d)/d, T the time constant, d the impedance, and w the
inverse mass that acts on a constraint (MuJoCo's documentation, Computation, "Constraint model").
MJX leaves out the term J' q'.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
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
    constraint = _Constraint(
        damping=damping,
        stiffness=damping / (2 * constant),
        softness=inverse_mass * (1 - loop.impedance) / loop.impedance,
        curved=loop.curved,
    )

    def forces(p: Any, time: Any, q: Any, v: Any) -> Any:
        """Returns the generalised forces of the open tree plus those that close the loop."""
        tree_forces, gap_jacobian, loop_forces = _loop_equation(
            tree, gaps, (p, time, q, v), constraint
        )
        return (tree_forces + gap_jacobian.T @ loop_forces).tolist()

    return replace(tree, forces=forces)


def loop_force(tree: SmoothSystem, gaps: Gaps, q: Array, v: Array) -> Array:
    """Returns the force [N] that keeps the `gaps` of a tree closed rigidly, shape (m,).

    It is l of eq. 1 without softness and gap. `q` and `v` are the tree's coordinates and rates,
    shape (n,) each.
    """
    _, _, force = _loop_equation(tree, gaps, (tree.values, 0.0, q, v), _Constraint())
    return force


@dataclass(frozen=True)
class _Constraint:
    """Coefficients of eq. 1; those of a rigid constraint by default."""

    damping: float = 0.0  # b [1/s]
    stiffness: float = 0.0  # k [1/s^2]
    softness: float = 0.0  # R [1/kg]
    curved: bool = True  # whether the term J' q' is included


def _loop_equation(
    tree: SmoothSystem,
    gaps: Gaps,
    state: tuple[Any, Any, Any, Any],
    constraint: _Constraint,
) -> tuple[Array, Array, Array]:
    """Returns f, J and l of eq. 1 in a `state` of p, t, q and q'."""
    p, _, q, v = state
    mass: Array = np.array(tree.mass_matrix(p, q))
    tree_forces: Array = np.array(tree.forces(*state))
    gap, jacobian, curvature = (np.array(part) for part in gaps(p, q, v))
    mobility = np.linalg.solve(mass, jacobian.T)
    required = -constraint.damping * (jacobian @ np.array(v)) - constraint.stiffness * gap
    required = required - mobility.T @ tree_forces
    if constraint.curved:
        required = required - curvature
    inverse_mass = jacobian @ mobility + constraint.softness * np.eye(len(gap))
    return tree_forces, jacobian, np.linalg.solve(inverse_mass, required)
