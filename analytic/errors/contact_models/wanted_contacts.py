"""Soft contacts of MuJoCo with a wanted restitution, depth at rest or creep, and what fixed steps
make of them.

A contact with a constant impedance d and the time constant T is critically damped. Under a load
that accelerates the free body by g it rests at the depth (1 - d) T^2 g. If friction holds a force
that accelerates the free body by p, the contact creeps at (1 - d)/d p/(ratio b), with the damping
b = 2/(d T). Both follow from the law in soft_friction.py. Neither depends on the mass of a body
that carries itself alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from plumbob.analytic.errors.contact_models.impacts import (
    IMPACT_IMPEDANCE,
    SMALLEST_RESTITUTION,
    SoftImpact,
    damped_impact,
)
from plumbob.analytic.errors.contact_models.soft_friction import depth_under, impedance, rates
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import SoftPoint

LARGEST_RESTITUTION = 0.98
# Moments of an impact within a step. The extremes of 64 and of 1024 moments differ by 1e-3.
IMPACT_PHASES = 64
LARGEST_DAMPING_RATIO = 10.0
IMPACT_STEPS = 400  # a contact lasts 16 steps; one that takes longer does not rebound
STIFFEST_IMPEDANCE, SOFTEST_IMPEDANCE = 0.9999, 0.5
STEPS_PER_TIME_CONSTANT = 2.0  # MuJoCo raises a smaller time constant to this many steps
LARGEST_FRICTION_RATIO = 1e6  # impratio up to which the predicted creep was measured
# [m/s] speeds of impacts whose squares are far from what double precision holds
SLOWEST_IMPACT, FASTEST_IMPACT = 1e-6, 1e6
# Least speed of an impact over the speed that gravity gives in a step. At slower impacts, a contact
# with a wanted restitution of 0.9 can rebound with more than 1.
LEAST_FALL_STEPS = 5.0
# [m/s^2] accelerations by loads, and [m] the largest depth: beyond them no contact is a robot's
LEAST_PUSH, LARGEST_PUSH, LARGEST_DEPTH = 1e-9, 1e9, 10.0


@dataclass(frozen=True)
class Rebound:
    """The outcome of an impact, over its moments within a step."""

    impact: SoftImpact
    low: float  # smallest restitution; 0 if some impacts do not rebound
    high: float
    depth: float  # [m] largest depth


def rebounds(
    impact: SoftImpact, speed: float, step: float, gravity: float
) -> tuple[Array, Array]:
    """Returns the restitution and the depth [m] of impacts at a `speed` [m/s], each of shape
    (IMPACT_PHASES,), for as many moments of the impact within a step of Euler of `step` [s]. A
    restitution is 0 if the body does not rebound."""
    height = np.arange(IMPACT_PHASES) / IMPACT_PHASES * speed * step
    velocity = -np.sqrt(speed**2 - np.minimum(2.0 * gravity * height, 0.5 * speed**2))
    restitution = np.zeros(IMPACT_PHASES)
    depth = np.zeros(IMPACT_PHASES)
    pending = np.ones(IMPACT_PHASES, dtype=bool)
    for _ in range(IMPACT_STEPS):
        touching = height < 0.0
        push = (IMPACT_IMPEDANCE - 1.0) * gravity - impact.damping * velocity
        push = np.maximum(-gravity, push - impact.stiffness * height)
        velocity = velocity + step * np.where(touching, push, -gravity)
        height = height + step * velocity
        depth = np.maximum(depth, np.where(pending, -height, 0.0))
        leaves = pending & touching & (height >= 0.0)
        at_floor = np.sqrt(velocity**2 + 2.0 * gravity * np.maximum(height, 0.0))
        restitution = np.where(leaves, at_floor / speed, restitution)
        pending &= ~leaves
    return restitution, depth


def bouncing_contact(restitution: float, speed: float, step: float, gravity: float) -> Rebound:
    """Returns the contact that has the wanted `restitution` at a `speed` [m/s], in steps of Euler
    of `step` [s], as the mean over the moments of the impact within a step. Raises ParameterError
    if there is none."""
    if not SMALLEST_RESTITUTION <= restitution <= LARGEST_RESTITUTION:
        allowed = f"from {SMALLEST_RESTITUTION:g} to {LARGEST_RESTITUTION:g}"
        raise ParameterError("restitution", restitution, allowed)
    least_speed = max(SLOWEST_IMPACT, LEAST_FALL_STEPS * gravity * step)
    if speed < least_speed:
        raise ParameterError("speed", speed, f"at least {least_speed:.3g} m/s at this step")
    if speed > FASTEST_IMPACT:
        raise ParameterError("speed", speed, f"at most {FASTEST_IMPACT:g} m/s")

    def excess(damping_ratio: float) -> float:
        """Returns by how much the mean restitution exceeds the wanted one."""
        outcome, _ = rebounds(damped_impact(damping_ratio, step), speed, step, gravity)
        return float(outcome.mean()) - restitution

    if excess(LARGEST_DAMPING_RATIO) > 0.0 or excess(0.0) < 0.0:
        allowed = "one that impacts at this speed and step can have"
        raise ParameterError("restitution", restitution, allowed)
    damping_ratio = float(brentq(excess, 0.0, LARGEST_DAMPING_RATIO, xtol=1e-6))
    impact = damped_impact(damping_ratio, step)
    outcome, depth = rebounds(impact, speed, step, gravity)
    return Rebound(impact, float(outcome.min()), float(outcome.max()), float(depth.max()))


def resting_contact(depth: float, push: float, step: float) -> SoftPoint:
    """Returns the contact that rests at a `depth` [m] under a load that accelerates the free body
    by `push` [m/s^2], in steps of `step` [s]. Its time constant is MuJoCo's default if an impedance
    allows it. Raises ParameterError if no contact is stiff enough."""
    if depth > LARGEST_DEPTH:
        raise ParameterError("penetration", depth, f"at most {LARGEST_DEPTH:g} m")
    wanted = depth / push  # [s^2]: (1 - d) T^2
    softest, stiffest = 1.0 - SOFTEST_IMPEDANCE, 1.0 - STIFFEST_IMPEDANCE
    shortest = STEPS_PER_TIME_CONSTANT * step
    if wanted < stiffest * shortest**2:
        least = stiffest * shortest**2 * push
        largest_step = math.sqrt(wanted / stiffest) / STEPS_PER_TIME_CONSTANT
        requirement = (
            f"at least {least:.3g} m at this step; it needs a step of {largest_step:.3g} s"
        )
        raise ParameterError("penetration", depth, requirement)
    time_constant = max(SoftPoint().time_constant, shortest)
    time_constant = min(time_constant, math.sqrt(wanted / stiffest))
    time_constant = max(time_constant, math.sqrt(wanted / softest))
    constant = 1.0 - wanted / time_constant**2
    return SoftPoint(time_constant=time_constant, impedance=(constant, constant))


def creep_of(point: SoftPoint, push: float, pull: float, step: float) -> float:
    """Returns the speed [m/s] at which a contact with an elliptic cone creeps. The load and the
    force that friction holds accelerate the free body by `push` and `pull` [m/s^2]."""
    d = impedance(point, depth_under(point, push, step))
    return (1.0 - d) / d * pull / (point.ratio * rates(point, step)[1])


def sticking_contact(creep: float, push: float, pull: float, step: float) -> SoftPoint:
    """Returns a contact with an elliptic cone that creeps at most at a speed `creep` [m/s].

    The other arguments are as in `creep_of`. Only the ratio differs from MuJoCo's defaults if that
    suffices; else the impedance is as large as MuJoCo allows. Raises ParameterError if neither
    suffices."""
    default = SoftPoint(pyramidal=False)
    stiff = replace(default, impedance=(STIFFEST_IMPEDANCE, STIFFEST_IMPEDANCE))
    for point in (default, stiff):
        ratio = creep_of(point, push, pull, step) / creep
        if ratio <= LARGEST_FRICTION_RATIO:
            return replace(point, ratio=max(1.0, ratio))
    least = creep_of(replace(stiff, ratio=LARGEST_FRICTION_RATIO), push, pull, step)
    raise ParameterError("creep", creep, f"at least {least:.3g} m/s at this load")
