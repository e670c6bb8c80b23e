"""Model errors of sequential impulses on a motion of the capsule: bounds by reason.

Theory steps the motion as such an engine does (errors.position_first), but for three things.

Solver iterations: where the slider or friction asks for another force than in the step before, the
iterations of one step leave a fraction of the change of velocity. They leave the same at every
foot, whatever its load, so when a sliding body comes to rest and is held from the other side its
light feet reach their friction limits, and the fraction is bounded by the convergence factor with
one sticking foot. The next steps remove it, as far as friction has something to spare; where it has
nothing, more iterations hardly help; and while the body slides after one foot has begun to stick or
to slip, the other feet are at their limits, and the residual persists until rest.

Straight steps: feet and body are separate and move straight in a step, not on circles, which gives
them a moment of their own: a turn by an angle a in a step has a relative error of a^2 at most.

Rounding: a joint that closes its opening in one step turns the last bit of a position into a
velocity, in each step again: positions make a random walk. Derivations: THEORY.md, section 10.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.errors.contact_models.model_error import (
    BodyError,
    Bounds,
    ModelError,
    SampledMotion,
    by_observable,
    radius_of_gyration,
    sampled,
    support_arm,
)
from plumbob.analytic.errors.contact_models.sequential_impulse import (
    ROUNDINGS,
    SequentialImpulse,
)
from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.systems.capsule import NORMAL_FORCES, steepest_load
from plumbob.analytic.systems.capsule_setup import CapsuleProblem

USED_UP = 0.02  # of friction to spare, below which iterations stall: calibrated
STALLED = 1e-2  # fraction of a velocity left there, 7e-3 with 50 iterations: calibrated
# Of the friction limit: what changes by more between samples does so at once. In each phase
# friction is constant but for rounding; the slow return of repeated ones begins with 0.1.
JUMP = 1e-3
AT_SWITCH = 1e-9  # [s]: an event this near to a switch of the slider is caused by it


@dataclass(frozen=True)
class Demand:
    """Demand on the solver: how often forces change at once, by how much per mass friction's does,
    and the slider's while every foot sticks [m/s^2]; the fraction of friction to spare while it
    holds or is overcome; and how long the body slides on the residual of a foot's change [s]."""

    changes: int
    jump: float
    spare: float = 1.0
    push: float = 0.0
    sliding: float = 0.0


def model_error(
    problem: CapsuleProblem, duration: float, solver: SequentialImpulse
) -> ModelError:
    """{observable: {reason: bound}} over `duration` [s] of all mechanisms of the solver's model;
    empty for bare pivots in the plane, whose friction is not Coulomb's."""
    kind = problem.motion.kind
    motion = sampled(problem, duration)
    if solver.model == "pivots" and kind == "plane":
        return {}
    bounds = {"rounding of positions": _rounding(motion, duration, solver)}
    # Friction of pivots is Coulomb's where the body turns about C; elsewhere no bound is known.
    if solver.model != "pivots" or kind == "coasting":
        bounds["solver iterations"] = _iterations(problem, motion, duration, solver)
    if solver.model == "feet":
        bounds["straight steps of feet"] = _straight_feet(motion, solver, kind == "coasting")
    if solver.model == "side":
        bounds["contact depth"] = _contact_depth(problem, motion, solver)
    return by_observable(bounds)


def demand(problem: CapsuleProblem, motion: SampledMotion) -> Demand:
    """The motion's demand on the solver."""
    capsule = motion.capsule
    limit = _limit(problem)
    pushes = capsule.mass_ratio * np.abs(motion.push)
    if not motion.formula:
        single = problem.motion.single
        times = np.clip(single.path.breakpoints, 0.0, None)
        changes = motion.count * (len(single.events) + times.size)
        sliding = motion.count * _sliding(single, times)
        return Demand(changes, limit, push=float(pushes.max()), sliding=sliding)
    # A body that starts from rest slips from the second sample on.
    jumps = np.abs(np.diff(motion.traction[:, 1:])).max(axis=0) * problem.setup.press
    sudden = int(np.count_nonzero(jumps > JUMP * limit))
    used = pushes[pushes > 0.0] / limit if limit else np.zeros(0)
    # Friction limits of feet change as the slider goes.
    moved = np.abs(motion.place - motion.place[0]).max() * steepest_load(capsule) / motion.mass
    return Demand(
        motion.count * (sudden + bool(motion.slips[:, 1].any())),
        float(jumps.max() + capsule.friction * moved * bool(sudden)),
        float(np.abs(1.0 - used).min(initial=1.0)),
    )


def _limit(problem: CapsuleProblem) -> float:
    """Friction limit per mass, f g [m/s^2]."""
    return problem.setup.capsule.friction * problem.setup.press


def _sliding(single: Any, switches: Any) -> float:
    """Time [s] from each event in which a foot sticks or slips, other than at a switch of the
    slider, to the rest that follows; and the longest slide that a switch starts.

    A push that begins in the last half per cent of a step starts the body with the residual: of a
    plan's some ninety pushes at most one or two do. Such a step demands a push of at most the
    friction, or no foot would stick, and for friction too: the slide counts twice.
    """
    sliding = 0.0
    longest = 0.0
    resting = single.rest_time
    modes_before = (None, *(event.mode for event in single.events[:-1]))
    for event, before in zip(reversed(single.events), reversed(modes_before), strict=True):
        if event.mode == "rest":
            resting = event.time
        elif event.mode == "pivot" or np.abs(switches - event.time).min() > AT_SWITCH:
            sliding += resting - event.time
        elif before == "rest":
            longest = max(longest, resting - event.time)
    return float(sliding + 2.0 * longest)


def _iterations(
    problem: CapsuleProblem, motion: SampledMotion, duration: float, solver: SequentialImpulse
) -> Bounds:
    """A velocity left at each change decays under the friction to spare, or lasts to the end. A
    switch inside a step changes the velocity in that step by a part, in the next by the rest: of
    the slider's push, too, something is left for two steps."""
    need = demand(problem, motion)
    limit = _limit(problem)
    step = solver.step
    residual = solver.residual
    if solver.model != "side":
        stalls = STALLED if need.spare < USED_UP else 0.0
        residual = max(solver.one_foot_residual, stalls)
    stopped = residual * need.jump * step
    spare = need.spare * limit
    left = stopped + solver.residual * need.push * step
    lasting = min(stopped / spare, duration) if spare else duration * bool(stopped)
    lasting += (2.0 if need.push else 1.0) * step
    way = need.changes * left * lasting + stopped * need.sliding
    # Iterations reduce the kinetic energy: a residual rate is a residual speed over the radius of
    # gyration, or over the supports' arm if that is shorter.
    capsule = motion.capsule
    speed = 2.0 * left
    radius = min(support_arm(capsule), radius_of_gyration(capsule))
    error = BodyError(
        way, speed, way / radius, speed / radius, speed * step, left, 2.0 * left / step
    )
    bounds = motion.bounds(error, step)
    if solver.model != "side":
        return bounds
    # Its normal forces are the contacts' own impulses.
    return {**bounds, **dict.fromkeys(NORMAL_FORCES, bounds["friction_force"])}


def _rounding(motion: SampledMotion, duration: float, solver: SequentialImpulse) -> Bounds:
    """See the module's text."""
    arm = support_arm(motion.capsule)
    step = solver.step
    gone = motion.way + float(np.abs(motion.place - motion.place[0]).max())
    size = float(np.abs(motion.place[0])) + arm + gone
    bit = ROUNDINGS * ROUNDOFF * size
    way = bit * math.sqrt(duration / step)
    speed = bit / step
    loads = motion.mass * (1.0 + size / _base(solver)) * speed / step
    error = BodyError(way, speed, way / arm, speed / arm, way, speed, 2.0 * speed / step)
    return {**motion.bounds(error, step), **dict.fromkeys(NORMAL_FORCES, loads)}


def _base(solver: SequentialImpulse) -> float:
    """Distance of the hindmost and the foremost support along the line [m]."""
    return solver.reach[1] - solver.reach[0]


def _contact_depth(
    problem: CapsuleProblem, motion: SampledMotion, solver: SequentialImpulse
) -> Bounds:
    """Friction acts below C by the overlap: its moment moves load from one foot to the other, and
    the centre of pressure that the supports carry."""
    capsule = motion.capsule
    moment = _limit(problem) * motion.mass * solver.depth
    moved = moment * steepest_load(capsule) / (capsule.slider_mass * capsule.gravity)
    return dict.fromkeys(NORMAL_FORCES, moment / _base(solver) + moved)


def _straight_feet(motion: SampledMotion, solver: SequentialImpulse, coasting: bool) -> Bounds:
    """A foot moves straight and not on a circle."""
    rates = np.abs(motion.rate)
    relative = float(rates.max() * solver.step) ** 2
    angle = relative * motion.count * float(np.trapezoid(rates, motion.times))
    rate = relative * float(rates.max())
    arm = support_arm(motion.capsule) * coasting
    return motion.bounds(BodyError(angle * arm, rate * arm, angle, rate), solver.step)
