"""Errors of steps on a ball that bounces, by stepping the contact models of MuJoCo and pymunk.

A spring and damper that only pushes, without gravity, has the restitution e = exp(-2 zeta
acos(zeta)/sqrt(1 - zeta^2)) (Schwager and Poeschel 2007, Granular Matter 9, 465; with zeta =
sin(phi) this one formula unites their eqs. 20 and 21). A soft contact of MuJoCo with impedance d
gives the acceleration (1 - d) a_0 - b v - k z, but never less than the acceleration a_0 without
contact (MuJoCo's documentation, "Computation", constraint model).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from plumbob.analytic.errors.smooth_motion.scheme_steps import (
    Equations,
    StateParts,
    scheme_step,
    states_after,
    whole_steps,
)
from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, TABLEAUX, Scheme
from plumbob.analytic.systems.bouncing_ball import BouncingBall
from plumbob.analytic.theory import Predicted, StepErrors, SteppedErrors

# MuJoCo's d. With 1 - d = 0.01 the solver loses two digits, and 1 % of gravity acts during contact.
IMPACT_IMPEDANCE = 0.99
# chosen: angular frequency of the spring times the step; a contact lasts 16 steps
IMPACT_PHASE_PER_STEP = 0.2
# smallest restitution of a spring and damper: even overdamped, it rebounds
SMALLEST_RESTITUTION = 0.01
# fraction of a penetration left after 1 s: pymunk's default
PENETRATION_LEFT = 0.899999976158142**60
SOLVER_ITERATIONS = 50  # solver iterations of pymunk for the two impulses of an impact
# Penetration that pymunk leaves, as a fraction of the initial height
ALLOWED_PENETRATION = 1e-4
# relative change of the inputs that changes a run as much as the rounding of its steps does
ROUNDING_AS_CHANGE = 2.0 * ULP


def damping_ratio(restitution: float) -> float:
    """Returns the damping ratio zeta of a contact with a `restitution`, at least
    SMALLEST_RESTITUTION."""
    loss = -math.log(max(restitution, SMALLEST_RESTITUTION))
    if not loss:
        return 0.0
    return float(brentq(lambda zeta: log_loss(zeta) - loss, 0.0, 10.0, xtol=1e-15))


def log_loss(zeta: float) -> float:
    """Returns -log e of the restitution e of a damping ratio."""
    if abs(zeta - 1.0) < 1e-9:
        return 2.0
    angle = math.acos(zeta) if zeta < 1.0 else math.acosh(zeta)
    return 2.0 * zeta * angle / math.sqrt(abs(1.0 - zeta**2))


@dataclass(frozen=True)
class SoftImpact:
    """Spring k [1/s^2] and damper b [1/s] of a contact, each divided by the mass."""

    stiffness: float
    damping: float

    @property
    def solref(self) -> tuple[float, float]:
        """Stiffness and damping as MuJoCo's parameter `solref`."""
        return -self.stiffness, -self.damping

    def contact_acceleration(self, z: float, speed: float) -> float:
        """Returns the acceleration [m/s^2] by spring and damper alone, at a height z < 0 [m]."""
        return max(0.0, -self.stiffness * z - self.damping * speed)

    def acceleration(self, gravity: float, z: float, speed: float) -> float:
        """Returns the acceleration [m/s^2] of a ball whose lowest point is at the height z [m]."""
        if z >= 0.0:
            return -gravity
        weight = (IMPACT_IMPEDANCE - 1.0) * gravity
        return max(-gravity, weight - self.damping * speed - self.stiffness * z)


def soft_impact(restitution: float, step: float) -> SoftImpact:
    """Returns the contact with a `restitution` for steps of `step` [s]."""
    return damped_impact(damping_ratio(restitution), step)


def damped_impact(zeta: float, step: float) -> SoftImpact:
    """Returns the contact with a damping ratio `zeta` for steps of `step` [s].

    The spring's angular frequency is IMPACT_PHASE_PER_STEP over the step. If the contact is
    overdamped, the spring is softer, so that the damper is stable too."""
    rate = IMPACT_PHASE_PER_STEP / (step * max(zeta, 1.0))
    return SoftImpact(rate**2, 2.0 * zeta * rate)


def held_impulses(
    velocity: Array, inverse_masses: Array, friction: float, normal_impulse: float
) -> Array:
    """Returns a contact point's impulses [N s] along the floor and normal to it, shape (2,).

    `velocity` is the point's velocity [m/s] along the floor and normal to it before the impulses,
    shape (2,), and `inverse_masses` [1/kg], shape (2, 2), times the impulses are its change. The
    impulse of friction is the one that stops the slip, if it need not exceed `friction` times
    `normal_impulse` [N s]. Otherwise it is limited to this product.
    """
    limit = friction * normal_impulse
    sticking = (-velocity[0] - inverse_masses[0, 1] * normal_impulse) / inverse_masses[0, 0]
    return np.array([np.clip(sticking, -limit, limit), normal_impulse])


def hard_impulses(
    velocity: Array, inverse_masses: Array, friction: float, fall: float, restitution: float
) -> Array:
    """Returns pymunk's impulses [N s] along the floor and normal to it, shape (2,).

    Arguments are as in `held_impulses`. Pymunk solves the two impulses in turns. The normal impulse
    reverses the `velocity`, which does not include the speed `fall` [m/s] that gravity adds in the
    step, and cancels `fall`.
    """
    along, normal = 0, 1
    bounce = restitution * min(velocity[1], 0.0)
    changes = np.array([-velocity[0], fall - velocity[1] - bounce])
    impulses = np.zeros(2)
    for _ in range(SOLVER_ITERATIONS):
        missing = changes[normal] - inverse_masses[normal] @ impulses
        unclamped = impulses[normal] + missing / inverse_masses[normal, normal]
        impulses[normal] = max(unclamped, 0.0)
        limit = friction * impulses[normal]
        missing = changes[along] - inverse_masses[along] @ impulses
        sticking = impulses[along] + missing / inverse_masses[along, along]
        impulses[along] = np.clip(sticking, -limit, limit)
    return impulses


def soft_heights(ball: BouncingBall, scheme: Scheme, step: float, marks: list[int]) -> Array:
    """Returns heights z [m] after the numbers of steps `marks`, with MuJoCo's contact."""
    impact = soft_impact(ball.restitution, step)

    def acceleration(time: float, z: StateParts, speed: StateParts) -> StateParts:
        """Returns the ball's acceleration [m/s^2]."""
        return (impact.acceleration(ball.gravity, *z, *speed),)

    advance = scheme_step(scheme, Equations(acceleration, 1), step)
    return np.array([z for z, _ in states_after(advance, (ball.height, 0.0), step, marks)])


def hard_heights(ball: BouncingBall, step: float, marks: list[int]) -> Array:
    """Returns heights z [m] after the numbers of steps `marks`, with pymunk's contact.

    If the ball has moved below the floor, the contact reverses its speed, before gravity acts. A
    second velocity reduces the penetration down to the allowed one, `slop`.
    """
    closed_fraction = 1.0 - PENETRATION_LEFT**step
    slop = ALLOWED_PENETRATION * ball.height

    def advance(time: float, state: StateParts) -> StateParts:
        """Returns height, speed and closing speed after a step."""
        z, speed, closing_speed = state
        z += step * (speed + closing_speed)
        rebound = -ball.restitution * speed if z < 0.0 else -math.inf
        closing_speed = closed_fraction * max(0.0, -z - slop) / step
        return z, max(speed - step * ball.gravity, rebound), closing_speed

    start = (ball.height, 0.0, 0.0)
    return np.array([z for z, *_ in states_after(advance, start, step, marks)])


def bouncing_errors(ball: BouncingBall) -> StepErrors:
    """Returns the errors of steps on a ball; empty for schemes that are not stepped here.

    A rebound depends on the moment of the impact within its step, and each impact amplifies the
    rounding of that moment. The uncertainty is therefore the difference to neighbouring balls.
    Their height and gravity are changed by as much as rounding. In a solver for soft contacts
    rounding is 1/(1 - d) times larger.
    """

    def error(scheme: Scheme, step: float, times: Array) -> Predicted:
        """Returns the error of the height, its uncertainty, and the penetration that pymunk
        leaves."""
        marks = whole_steps(times, step).tolist()
        if scheme.integrator not in (EULER, *TABLEAUX):
            return {}

        def heights(ball: BouncingBall) -> Array:
            """Returns the stepped heights [m] of a ball."""
            if scheme.position_first:
                return hard_heights(ball, step, marks)
            return soft_heights(ball, scheme, step, marks)

        rounding = ROUNDING_AS_CHANGE
        if not scheme.position_first:
            rounding = ROUNDING_AS_CHANGE / (1.0 - IMPACT_IMPEDANCE)
        penetration = ALLOWED_PENETRATION * ball.height if scheme.position_first else 0.0
        z = heights(ball)
        doubt = np.full(len(z), rounding * ball.height)
        for name in ("height", "gravity"):
            neighbour = replace(ball, **{name: getattr(ball, name) * (1.0 + rounding)})
            doubt += np.abs(heights(neighbour) - z)
        error = z - ball.observe(times)["z"]
        return SteppedErrors({"z": error}, {"z": doubt}, {"z": np.full(len(z), penetration)})

    return StepErrors(error)
