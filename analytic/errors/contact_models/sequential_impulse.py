"""Sequential impulses: what a finite number of solver iterations leaves of a velocity, and the
record by which an engine says how it models a capsule's supports.

Solvers of this kind (Chipmunk, Box2D) go from joint to joint and correct velocities so that each
joint in turn is satisfied: block Gauss-Seidel on the joint impulses. One iteration is linear while
no friction limit is reached, so what it leaves of a velocity shrinks by the spectral radius of its
matrix. What that adds to the exact motion, apart from the step's own error, is bounded in
`sequential_impulse_bounds`. Derivations: THEORY.md, section 10.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule

TARGET = 1e-5  # residual fraction of a velocity at the end of a step: a choice
MOST_ITERATIONS = 5000  # in a step, which take half a millisecond: a choice
# factor of a velocity that an iteration leaves unchanged, but for rounding
LASTING = 1.0 - 1e-9
ROUNDINGS = 8  # from positions to a velocity: calibrated, see THEORY.md, section 10


@dataclass(frozen=True)
class SequentialImpulse:
    """How an engine of sequential impulses models the capsule: all that theory needs to know of
    it."""

    model: Literal["feet", "pivots", "side"]
    """Supports as small bodies with friction joints and pins; as friction joints on the body; or
    two contacts, seen from the side."""
    step: float  # [s]
    iterations: int  # of the solver in a step
    reach: tuple[float, float]  # hindmost and foremost support along the line, from C [m]
    factor: float = 1.0  # largest convergence factor of an iteration while every support sticks
    one_foot_factor: float = 1.0  # the same on a line while one foot sticks and the others slip
    depth: float = 0.0  # overlap at which contacts act [m]

    @property
    def residual(self) -> float:
        """Fraction of a velocity that a step leaves while every support sticks."""
        return self.factor**self.iterations

    @property
    def one_foot_residual(self) -> float:
        """The same with one sticking foot: a bound for any number of them."""
        return float(max(self.one_foot_factor, self.factor) ** self.iterations)


def convergence_factor(masses: Sequence[float], joints: Sequence[Array]) -> float:
    """Spectral radius of one iteration while every joint sticks.

    `masses` (or moments) belong to the velocities, shape (n,); each joint has the directions in
    which it acts as rows, shape (k, n). An iteration is the product of the joints' projections,
    I - M^-1 A_j^T (A_j M^-1 A_j^T)^-1 A_j.
    """
    return float(np.abs(np.linalg.eigvals(_iteration(masses, joints))).max())


def _iteration(masses: Sequence[float], joints: Sequence[Array]) -> Array:
    """The map of the velocities in one iteration, shape (n, n)."""
    inverse = np.diag(1.0 / np.asarray(masses))
    product = np.eye(len(masses))
    for joint in joints:
        pull = inverse @ joint.T
        product = product - pull @ np.linalg.solve(joint @ pull, joint @ product)
    return product


def iterations_needed(factor: float, least: int) -> int:
    """Iterations after which TARGET of a velocity is left when each leaves `factor` of it: `least`
    or more, and MOST_ITERATIONS or fewer unless `least` is more."""
    if factor >= TARGET ** (1.0 / MOST_ITERATIONS):
        return max(least, MOST_ITERATIONS)
    return max(least, math.ceil(math.log(TARGET) / math.log(max(factor, TARGET))))


def feet_factor(capsule: Capsule, foot_mass: float, slider: Array) -> float:
    """Convergence factor of a body with the slider pinned at `slider` from C [m], shape (2,), on
    three pinned feet of `foot_mass` [kg] that all stick.

    Momentum goes from the slider to the ground through the feet, and in one iteration no more of it
    than they can carry: light feet stop a heavy slider late.
    """
    corners = np.asarray(capsule.supports)
    count = 11
    core_mass = capsule.body_mass - 3 * foot_mass
    core_centre = -foot_mass * corners.sum(axis=0) / core_mass
    moment = float(
        capsule.inertia
        - core_mass * core_centre @ core_centre
        - foot_mass * np.square(corners).sum()
    )
    pins = [_pin(count, corner - core_centre, 5 + 2 * i) for i, corner in enumerate(corners)]
    sticking = [np.eye(count)[5 + 2 * i : 7 + 2 * i] for i in range(3)]
    masses = [core_mass, core_mass, moment, *[capsule.slider_mass] * 2, *[foot_mass] * 6]
    return convergence_factor(
        masses, [_pin(count, np.asarray(slider) - core_centre, 3), *pins, *sticking]
    )


def slipping_feet_factor(capsule: Capsule, foot_mass: float, sticking: int) -> float:
    """The same on a line, where all but so many feet slip."""
    unit = np.eye(5)
    masses = [capsule.body_mass - 3 * foot_mass, capsule.slider_mass, *[foot_mass] * 3]
    pins = [unit[:1] - unit[i : i + 1] for i in range(1, 5)]
    return convergence_factor(
        masses, [*pins, *(unit[i : i + 1] for i in range(2, 2 + sticking))]
    )


def pivots_factor(capsule: Capsule, slider: Array) -> float:
    """Convergence factor of a body with the slider pinned at `slider` from C [m], shape (2,), on
    three friction joints of its own, in the slowest state that it can come to rest in.

    A joint sticks; or its force is at the limit and turns, so that it stops motion across its arm
    alone; or its force is practically fixed. Velocities that no joint stops are left out.
    """
    states = []
    for corner in capsule.supports:
        sticking = _pin(5, np.asarray(corner))
        turning = [np.asarray([corner]) @ sticking] if any(corner) else []
        states.append([[sticking], [], *([joint] for joint in turning)])
    masses = [*[capsule.body_mass] * 2, capsule.inertia, *[capsule.slider_mass] * 2]
    pin = _pin(5, np.asarray(slider), 3)
    left = [
        np.abs(np.linalg.eigvals(_iteration(masses, [pin, *itertools.chain(*state)])))
        for state in itertools.product(*states)
    ]
    return max(float(factors[factors < LASTING].max(initial=0.0)) for factors in left)


def contacts_factor(
    capsule: Capsule, moment: float, reach: tuple[float, float], slider: float
) -> float:
    """Convergence factor of a body seen from the side, with `moment` of inertia [kg m^2], on two
    sticking contacts at `reach` along the line and with the slider at `slider`, from C [m]."""
    rows: list[Array] = []
    for place in reach:
        contact = _pin(5, np.array([place, 0.0]))
        rows += [contact[1:], contact[:1]]
    masses = [capsule.body_mass] * 2 + [moment] + [capsule.slider_mass] * 2
    return convergence_factor(masses, [*rows, _pin(5, np.array([slider, 0.0]), 3)])


def _pin(count: int, arm: Array, other: int | None = None) -> Array:
    """Velocity of a body at `arm` from its centre of mass [m], less that of the ground or of a part
    that does not turn: of `count` velocities the body's are the first three and the part's two from
    `other`."""
    rows = np.zeros((2, count))
    rows[:, :3] = [[1.0, 0.0, -arm[1]], [0.0, 1.0, arm[0]]]
    if other is not None:
        rows[:, other : other + 2] = -np.eye(2)
    return rows


def opening_error(mass: float, length: float, closing: float, step: float) -> float:
    """Error [N] of a joint's force by the rounding of its opening, for a `mass` [kg] at `length`
    [m] and a joint that closes at the rate `closing` [1/s], in steps of `step` [s].

    The opening is a difference of positions near `length`, a few units in their last place; the
    joint turns it into a velocity, and that into an impulse of one step.
    """
    return ROUNDINGS * ROUNDOFF * mass * length * closing / step
