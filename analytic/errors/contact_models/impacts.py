"""Errors of steps on a ball that bounces: contacts as MuJoCo and pymunk have them, stepped.

A spring and damper without gravity that pushes only gives back e = exp(-2 zeta acos(zeta)/
sqrt(1 - zeta^2)) of the speed (Schwager and Poeschel 2007, Granular Matter 9, 465, eqs. 20 and 21,
where zeta = sin(phi) makes one formula of them). A soft contact of MuJoCo with impedance d has the
acceleration (1 - d) a_0 - b v - k z where that is above a_0, the one without contact (MuJoCo's
documentation, "Computation", constraint model).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from plumbob.analytic.errors.smooth_motion.scheme_steps import (
    Equations,
    Parts,
    advance,
    states_after,
    whole_steps,
)
from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, TABLEAUX, Scheme
from plumbob.analytic.systems.bouncing_ball import BouncingBall
from plumbob.analytic.theory import Predicted, StepErrors, SteppedErrors

IMPEDANCE = 0.99  # d: the solver loses two digits, and gravity acts by 1 %
RATE = 0.2  # chosen: of the spring, per step: a contact lasts for 16 steps
LEAST = 0.01  # of a spring and damper: an overdamped one gives something back, too
KEPT = 0.899999976158142**60  # of a penetration after 1 s, pymunk's default
ITERATIONS = 50  # of pymunk's solver, where an impact has two impulses
SLOP = 1e-4  # of the height: the penetration that pymunk leaves
NEARBY = 2.0 * ULP  # relative change of inputs, by which a run changes as by rounding


def damping_ratio(restitution: float) -> float:
    """Damping ratio zeta of a contact with this restitution, or LEAST if that is larger."""
    loss = -math.log(max(restitution, LEAST))
    return float(brentq(lambda zeta: lost(zeta) - loss, 0.0, 10.0, xtol=1e-15)) if loss else 0.0


def lost(zeta: float) -> float:
    """-log e of a damping ratio."""
    if abs(zeta - 1.0) < 1e-9:
        return 2.0
    angle = math.acos(zeta) if zeta < 1.0 else math.acosh(zeta)
    return 2.0 * zeta * angle / math.sqrt(abs(1.0 - zeta**2))


@dataclass(frozen=True)
class SoftImpact:
    """Spring k [1/s^2] and damper b [1/s] of a contact, each over the mass."""

    stiffness: float
    damping: float

    @property
    def solref(self) -> tuple[float, float]:
        """The two as MuJoCo takes them."""
        return -self.stiffness, -self.damping

    def pressed(self, z: float, speed: float) -> float:
        """Acceleration [m/s^2] by the spring and damper alone at a depth z < 0 [m]."""
        return max(0.0, -self.stiffness * z - self.damping * speed)

    def acceleration(self, gravity: float, z: float, speed: float) -> float:
        """Of a ball whose lowest point is at z [m] [m/s^2]."""
        if z >= 0.0:
            return -gravity
        return max(
            -gravity, (IMPEDANCE - 1.0) * gravity - self.damping * speed - self.stiffness * z
        )


def soft_impact(restitution: float, step: float) -> SoftImpact:
    """The contact of a `restitution` for a `step` [s]: a spring of RATE a step, or where it is
    overdamped a softer one, so that the damper is stable too."""
    zeta = damping_ratio(restitution)
    rate = RATE / (step * max(zeta, 1.0))
    return SoftImpact(rate**2, 2.0 * zeta * rate)


def held_impulses(ends: Array, weights: Array, friction: float, push: float) -> Array:
    """Impulses along the floor and off it [N s] of a point with velocities `ends` [m/s] and inverse
    masses `weights` [1/kg], shape (2, 2): `push`, with a friction that ends slip."""
    most = friction * push
    return np.array(
        [np.clip((-ends[0] - weights[0, 1] * push) / weights[0, 0], -most, most), push]
    )


def hard_impulses(
    ends: Array, weights: Array, friction: float, pull: float, restitution: float
) -> Array:
    """The same of pymunk, which solves them in turns; the normal one turns round the velocity
    before a step's gravity, `pull` [m/s]."""
    lacks = np.array([-ends[0], pull - ends[1] - restitution * min(ends[1], 0.0)])
    impulses = np.zeros(2)
    for _ in range(ITERATIONS):
        for row in (1, 0):
            impulses[row] += (lacks[row] - weights[row] @ impulses) / weights[row, row]
            most = friction * impulses[1]
            impulses[row] = np.clip(
                impulses[row], *((-most, most) if row == 0 else (0.0, np.inf))
            )
    return impulses


def soft_heights(ball: BouncingBall, scheme: Scheme, step: float, marks: list[int]) -> Array:
    """Heights z [m] after the numbers of steps `marks`, with MuJoCo's contact."""
    impact = soft_impact(ball.restitution, step)
    gravity = ball.gravity
    equations = Equations(lambda time, z, speed: (impact.acceleration(gravity, *z, *speed),), 1)
    take = advance(scheme, equations, step)
    return np.array([z for z, _ in states_after(take, (ball.height, 0.0), step, marks)])


def hard_heights(ball: BouncingBall, step: float, marks: list[int]) -> Array:
    """Heights z [m] after the numbers of steps `marks`, with pymunk's contact: where the moved ball
    is below the floor, the speed before gravity is turned round, and a penetration is closed."""
    closed = 1.0 - KEPT**step
    slop = SLOP * ball.height

    def take(time: float, state: Parts) -> Parts:
        z, speed, push = state
        z += step * (speed + push)
        back = -ball.restitution * speed if z < 0.0 else -math.inf
        push = closed * max(0.0, -z - slop) / step
        return z, max(speed - step * ball.gravity, back), push

    start = (ball.height, 0.0, 0.0)
    return np.array([z for z, *_ in states_after(take, start, step, marks)])


def bouncing_errors(ball: BouncingBall) -> StepErrors:
    """The errors of contacts on a ball; empty for schemes that are not stepped here. A rebound
    depends on where in its step the impact is, and each impact amplifies what rounding does to
    that: neighbours are stepped too, that differ by rounding, which in a solver for soft contacts
    is 1/(1 - d) times as much."""

    def error(scheme: Scheme, step: float, times: Array) -> Predicted:
        marks = whole_steps(times, step).tolist()
        if scheme.integrator not in (EULER, *TABLEAUX):
            return {}

        def heights(ball: BouncingBall) -> Array:
            if scheme.position_first:
                return hard_heights(ball, step, marks)
            return soft_heights(ball, scheme, step, marks)

        rounding = NEARBY if scheme.position_first else NEARBY / (1.0 - IMPEDANCE)
        z = heights(ball)
        doubt = np.full(len(z), rounding * ball.height)
        for name in ("height", "gravity"):
            changed = replace(ball, **{name: getattr(ball, name) * (1.0 + rounding)})
            doubt += np.abs(heights(changed) - z)
        left = np.full(len(z), SLOP * ball.height if scheme.position_first else 0.0)
        return SteppedErrors({"z": z - ball.observe(times)["z"]}, {"z": doubt}, {"z": left})

    return StepErrors(error)
