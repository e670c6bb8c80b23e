"""Sequential impulses: the residual of a velocity after a finite number of solver iterations.

Solvers of this kind (Chipmunk, Box2D) go from joint to joint and correct velocities so that each
joint in turn is satisfied: block Gauss-Seidel on the joint impulses. As long as no friction limit
is reached, one iteration is linear. The residual then shrinks by the spectral radius of the
iteration's matrix. The error that the residual adds to the exact motion is bounded in
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

TARGET_RESIDUAL = 1e-5  # chosen: residual fraction of a velocity at the end of a step
MOST_ITERATIONS = 5000  # chosen: iterations in a step, which take half a millisecond
UNREDUCED_FACTOR = 1.0 - 1e-9  # convergence factor above which a velocity is not reduced at all
# calibrated: roundings from a position to a velocity (THEORY.md, section 10)
VELOCITY_ROUNDINGS = 8


@dataclass(frozen=True)
class SequentialImpulse:
    """Model of the capsule in an engine of sequential impulses, as an adapter describes it."""

    model: Literal["feet", "pivots", "side"]
    """Kind of the supports. Feet are small bodies with pins and friction joints. Pivots are
    friction joints on the body. "side" is a view from the side, with two contacts."""
    step: float  # [s]
    iterations: int  # solver iterations in a step
    reach: tuple[float, float]  # [m] hindmost and foremost support along the line, from C
    factor: float = 1.0  # largest convergence factor of an iteration while every support sticks
    one_foot_factor: float = 1.0  # largest convergence factor while one support sticks
    depth: float = 0.0  # [m] overlap at which contacts act

    @property
    def residual(self) -> float:
        """Residual fraction of a velocity after a step in which every support sticks."""
        return self.factor**self.iterations

    @property
    def one_foot_residual(self) -> float:
        """Bound on the residual fraction of a velocity for any number of sticking supports: the
        larger of the fractions with one and with all of them."""
        return float(max(self.one_foot_factor, self.factor) ** self.iterations)


def convergence_factor(masses: Sequence[float], joints: Sequence[Array]) -> float:
    """Returns the spectral radius of one iteration while every joint sticks.

    `masses` (or moments) belong to the velocities, shape (n,). Each joint is a matrix of shape
    (k, n) whose rows are the directions in which the joint acts. An iteration is the product of the
    joints' projections, I - M^-1 A_j^T (A_j M^-1 A_j^T)^-1 A_j.
    """
    return float(np.abs(np.linalg.eigvals(_iteration_matrix(masses, joints))).max())


def _iteration_matrix(masses: Sequence[float], joints: Sequence[Array]) -> Array:
    """Returns the matrix of one iteration, which maps velocities to velocities, shape (n, n)."""
    inverse = np.diag(1.0 / np.asarray(masses))
    product = np.eye(len(masses))
    for joint in joints:
        pull = inverse @ joint.T
        product = product - pull @ np.linalg.solve(joint @ pull, joint @ product)
    return product


def iterations_needed(factor: float, least: int) -> int:
    """Returns the number of iterations that reduce a velocity to the fraction TARGET_RESIDUAL.

    Each iteration leaves the fraction `factor`. The result is at least `least`, and at most
    MOST_ITERATIONS unless `least` is larger.
    """
    if factor >= TARGET_RESIDUAL ** (1.0 / MOST_ITERATIONS):
        return max(least, MOST_ITERATIONS)
    needed = math.log(TARGET_RESIDUAL) / math.log(max(factor, TARGET_RESIDUAL))
    return max(least, math.ceil(needed))


def feet_factor(capsule: Capsule, foot_mass: float, slider: Array) -> float:
    """Returns the convergence factor of a body on three pinned feet that all stick.

    The slider is pinned at `slider` from C [m], shape (2,). Each foot has `foot_mass` [kg].
    Momentum goes from the slider to the ground through the feet, and light feet carry little of it
    in one iteration: they stop a heavy slider late.
    """
    supports = np.asarray(capsule.supports)
    count = 11  # three velocities of the core, two of the slider, two of each foot
    core_mass = capsule.body_mass - 3 * foot_mass
    core_centre = -foot_mass * supports.sum(axis=0) / core_mass
    core_offset = core_mass * core_centre @ core_centre
    core_inertia = float(capsule.inertia - core_offset - foot_mass * np.square(supports).sum())
    slider_pin = _pin_jacobian(count, np.asarray(slider) - core_centre, 3)
    foot_pins = []
    sticking = []
    for i, support in enumerate(supports):
        foot_pins.append(_pin_jacobian(count, support - core_centre, 5 + 2 * i))
        sticking.append(np.eye(count)[5 + 2 * i : 7 + 2 * i])
    core = [core_mass, core_mass, core_inertia]
    masses = [*core, *[capsule.slider_mass] * 2, *[foot_mass] * 6]
    return convergence_factor(masses, [slider_pin, *foot_pins, *sticking])


def slipping_feet_factor(capsule: Capsule, foot_mass: float, sticking: int) -> float:
    """Returns the convergence factor of a body on three feet along a line, `sticking` of which
    stick while the others slip."""
    unit = np.eye(5)  # the body, the slider and three feet, one velocity each
    masses = [capsule.body_mass - 3 * foot_mass, capsule.slider_mass, *[foot_mass] * 3]
    pins = [unit[:1] - unit[i : i + 1] for i in range(1, 5)]
    sticking_feet = [unit[i : i + 1] for i in range(2, 2 + sticking)]
    return convergence_factor(masses, [*pins, *sticking_feet])


def pivots_factor(capsule: Capsule, slider: Array) -> float:
    """Returns the convergence factor of a body on three friction joints, in its slowest state.

    The slider is pinned at `slider` from C [m], shape (2,). Each joint is in one of three states.
    It sticks; or its force is at the limit and turns, so that it stops only motion across its arm;
    or its force is practically fixed. All combinations are tried. Velocities that no joint stops
    are left out.
    """
    states_of_supports = []
    for support in capsule.supports:
        sticking = _pin_jacobian(5, np.asarray(support))
        states = [[sticking], []]
        if any(support):
            states.append([np.asarray([support]) @ sticking])
        states_of_supports.append(states)
    masses = [*[capsule.body_mass] * 2, capsule.inertia, *[capsule.slider_mass] * 2]
    slider_pin = _pin_jacobian(5, np.asarray(slider), 3)
    slowest = 0.0
    for states_together in itertools.product(*states_of_supports):
        joints = [slider_pin, *itertools.chain(*states_together)]
        factors = np.abs(np.linalg.eigvals(_iteration_matrix(masses, joints)))
        slowest = max(slowest, float(factors[factors < UNREDUCED_FACTOR].max(initial=0.0)))
    return slowest


def contacts_factor(
    capsule: Capsule, moment: float, reach: tuple[float, float], slider: float
) -> float:
    """Returns the convergence factor of a body on two sticking contacts, seen from the side.

    The body has the `moment` of inertia [kg m^2]. The contacts are at `reach` along the line, the
    slider at `slider`, all from C [m].
    """
    contact_rows: list[Array] = []
    for place in reach:
        contact = _pin_jacobian(5, np.array([place, 0.0]))
        contact_rows += [contact[1:], contact[:1]]  # the normal is solved before friction
    masses = [capsule.body_mass] * 2 + [moment] + [capsule.slider_mass] * 2
    slider_pin = _pin_jacobian(5, np.array([slider, 0.0]), 3)
    return convergence_factor(masses, [*contact_rows, slider_pin])


def _pin_jacobian(count: int, arm: Array, other_index: int | None = None) -> Array:
    """Returns the Jacobian of a pin on a body, shape (2, count).

    It gives the body's velocity at `arm` from its centre of mass [m], less the velocity of the
    ground or of another part. The body's velocities are the first three of `count`. The other part
    does not turn: its two velocities begin at the index `other_index`; None stands for the ground.
    """
    rows = np.zeros((2, count))
    rows[:, :3] = [[1.0, 0.0, -arm[1]], [0.0, 1.0, arm[0]]]
    if other_index is not None:
        rows[:, other_index : other_index + 2] = -np.eye(2)
    return rows


def opening_error(mass: float, length: float, closing: float, step: float) -> float:
    """Returns the error [N] of a joint's force by the rounding of the joint's opening.

    The joint holds a `mass` [kg] at `length` [m] and closes its opening at the rate `closing`
    [1/s], in steps of `step` [s]. The opening is a difference of positions near `length`, and is
    rounded by a few units in their last place. The joint turns the opening into a velocity, and the
    velocity into the impulse of one step.
    """
    return VELOCITY_ROUNDINGS * ROUNDOFF * mass * length * closing / step
