"""Model errors of sequential impulses on a motion of the capsule: bounds by reason.

Theory steps the motion as such an engine does (errors.position_first), but for three mechanisms.

Solver iterations. When the force of the slider or of friction changes, the iterations of one step
leave a residual: a fraction of the change of velocity. The residual is equal at all feet, whatever
their loads. When a sliding body comes to rest and friction reverses, light feet therefore reach
their friction limits first. The fraction is bounded by the convergence factor with one sticking
foot. The next steps remove the residual if friction is below its limit. If friction is at its
limit, more iterations hardly help. If the body slides on after one foot has begun to stick or to
slip, the other feet are at their limits, and the residual persists until rest.

Straight steps. Feet and body are separate and move along straight lines in a step, not on circles.
If the body turns by an angle a in a step, the relative error of its rotation is a^2 at most.

Rounding. A joint that closes its opening in one step turns the last bit of a position into a
velocity. This happens in each step, so that positions make a random walk. Derivations: THEORY.md,
section 10.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.errors.contact_models.model_error import (
    BodyError,
    Bounds,
    ObservableErrors,
    SampledMotion,
    by_observable,
    radius_of_gyration,
    sample_motion,
    support_arm,
)
from plumbob.analytic.errors.contact_models.sequential_impulse import (
    VELOCITY_ROUNDINGS,
    SequentialImpulse,
)
from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.systems.capsule import NORMAL_FORCES, steepest_load
from plumbob.analytic.systems.capsule_setup import CapsuleProblem

# calibrated: spare fraction of the friction limit below which iterations stall
STALLING_SPARE_FRICTION = 0.02
# calibrated: fraction of a velocity that the iterations leave; 7e-3 with 50 iterations
RESIDUAL_FRACTION = 1e-2
# Friction that changes by more than this fraction of its limit between samples has jumped. In each
# phase friction is constant but for rounding. The slider's slow return in repeated
# manoeuvres begins with a jump of 0.1.
FRICTION_JUMP = 1e-3
AT_SWITCH = 1e-9  # [s] an event this close to a switch of the slider is caused by the switch


@dataclass(frozen=True)
class SolverDemand:
    """Demand of a motion on the solver: sudden changes of forces."""

    changes: int  # number of sudden changes
    jump: float  # [m/s^2] largest change of friction per mass
    spare: float = 1.0  # smallest relative distance of the push from the friction limit
    push: float = 0.0  # [m/s^2] largest force of the slider per mass while every foot sticks
    sliding: float = 0.0  # [s] time that the body slides with a residual from a foot's change


def model_error(
    problem: CapsuleProblem, duration: float, solver: SequentialImpulse
) -> ObservableErrors:
    """Returns the bounds of a solver over `duration` [s]: {observable: {reason: bound}}.

    They are empty for pivots in the plane, whose friction is not Coulomb's.
    """
    kind = problem.motion.kind
    motion = sample_motion(problem, duration)
    if solver.model == "pivots" and kind == "plane":
        return {}
    bounds = {"rounding of positions": _rounding_bounds(motion, duration, solver)}
    # Pivots have Coulomb friction only if the body turns about C. Otherwise no bound is known.
    if solver.model != "pivots" or kind == "coasting":
        bounds["solver iterations"] = _iteration_bounds(problem, motion, duration, solver)
    if solver.model == "feet":
        coasting = kind == "coasting"
        bounds["straight steps of feet"] = _straight_feet_bounds(motion, solver, coasting)
    if solver.model == "side":
        bounds["contact depth"] = _contact_depth_bounds(problem, motion, solver)
    return by_observable(bounds)


def solver_demand(problem: CapsuleProblem, motion: SampledMotion) -> SolverDemand:
    """Returns the demand of a motion on the solver.

    If the motion has no closed form, each event and each switch of the slider is a sudden change
    of friction, by its limit at most. Otherwise the sudden changes are the jumps between samples,
    and the start if the body slides then.
    """
    capsule = motion.capsule
    limit = _friction_limit(problem)
    pushes = capsule.mass_ratio * np.abs(motion.push)
    if not motion.formula:
        single = problem.motion.single
        switches = np.clip(single.path.breakpoints, 0.0, None)
        return SolverDemand(
            changes=motion.count * (len(single.events) + switches.size),
            jump=limit,
            push=float(pushes.max()),
            sliding=motion.count * _sliding_time(single, switches),
        )
    # The first sample is left out: a body that starts from rest slips from the second sample on.
    jumps = np.abs(np.diff(motion.traction[:, 1:])).max(axis=0) * problem.setup.press
    sudden = int(np.count_nonzero(jumps > FRICTION_JUMP * limit))
    slides_at_start = bool(motion.slips[:, 1].any())
    used = pushes[pushes > 0.0] / limit if limit else np.zeros(0)
    # The friction limits of the feet change as the slider moves.
    travel = np.abs(motion.place - motion.place[0]).max()
    load_change = travel * steepest_load(capsule) / motion.mass
    return SolverDemand(
        changes=motion.count * (sudden + slides_at_start),
        jump=float(jumps.max() + capsule.friction * load_change * bool(sudden)),
        spare=float(np.abs(1.0 - used).min(initial=1.0)),
    )


def _friction_limit(problem: CapsuleProblem) -> float:
    """Returns the friction limit per mass, f g [m/s^2]."""
    return problem.setup.capsule.friction * problem.setup.press


def _sliding_time(single: Any, switches: Any) -> float:
    """Returns the total time [s] that the body may slide with a residual of the solver.

    `single` is a ThreePointMotion, `switches` are the times [s] at which the slider's acceleration
    switches. If a foot begins to stick, or begins to slip without a switch, a residual lasts from
    that event to the next rest: this time is added.

    A switch that starts a slide from rest leaves a residual only if it is in the last half per cent
    of a step. At most one or two of some ninety pushes of a plan are: the longest of these slides
    is added. It is added twice, because push and friction each leave a residual; the push is at
    most the friction, because a foot still sticks in that step.
    """
    total = 0.0
    longest = 0.0
    rest_time = single.rest_time  # time of the next rest, as the events are read backwards
    modes_before = [None, *[event.mode for event in single.events[:-1]]]
    for event, mode_before in zip(reversed(single.events), reversed(modes_before), strict=True):
        if event.mode == "rest":
            rest_time = event.time
        elif event.mode == "pivot" or np.abs(switches - event.time).min() > AT_SWITCH:
            total += rest_time - event.time
        elif mode_before == "rest":
            longest = max(longest, rest_time - event.time)
    return float(total + 2.0 * longest)


def _iteration_bounds(
    problem: CapsuleProblem, motion: SampledMotion, duration: float, solver: SequentialImpulse
) -> Bounds:
    """Returns bounds on the error of unfinished solver iterations.

    Each change of a force leaves a residual velocity. If friction is below its limit, the spare
    friction stops the residual; otherwise the residual lasts to the end. If the slider's push
    switches inside a step, one part of the velocity changes in that step and the other part in the
    next. The push therefore leaves a residual for two steps.
    """
    demand = solver_demand(problem, motion)
    step = solver.step
    residual = solver.residual
    if solver.model != "side":
        stalled_residual = RESIDUAL_FRACTION if demand.spare < STALLING_SPARE_FRICTION else 0.0
        residual = max(solver.one_foot_residual, stalled_residual)
    friction_residual = residual * demand.jump * step
    velocity_residual = friction_residual + solver.residual * demand.push * step
    spare_friction = demand.spare * _friction_limit(problem)
    if spare_friction:
        decay_time = min(friction_residual / spare_friction, duration)
    else:
        decay_time = duration * bool(friction_residual)
    decay_time += (2.0 if demand.push else 1.0) * step
    distance = demand.changes * velocity_residual * decay_time
    distance += friction_residual * demand.sliding
    # Iterations never raise the kinetic energy, so that the residual rate of rotation is at most
    # the residual speed divided by the radius of gyration. If the supports' arm is shorter, the
    # speed is divided by this arm.
    capsule = motion.capsule
    speed = 2.0 * velocity_residual
    radius = min(support_arm(capsule), radius_of_gyration(capsule))
    error = BodyError(
        place=distance,
        speed=speed,
        angle=distance / radius,
        rate=speed / radius,
        slider_place=speed * step,
        slider_rate=velocity_residual,
        drive=2.0 * velocity_residual / step,
    )
    bounds = motion.bounds(error, step)
    if solver.model != "side":
        return bounds
    # Seen from the side, the normal forces are impulses of contacts, with a residual too.
    return {**bounds, **dict.fromkeys(NORMAL_FORCES, bounds["friction_force"])}


def _rounding_bounds(
    motion: SampledMotion, duration: float, solver: SequentialImpulse
) -> Bounds:
    """Returns bounds on the error by rounding of positions, which make a random walk (module
    docstring)."""
    arm = support_arm(motion.capsule)
    step = solver.step
    travel = motion.path_length + float(np.abs(motion.place - motion.place[0]).max())
    size = float(np.abs(motion.place[0])) + arm + travel
    rounding = VELOCITY_ROUNDINGS * ROUNDOFF * size
    distance = rounding * math.sqrt(duration / step)
    speed = rounding / step
    loads = motion.mass * (1.0 + size / _support_distance(solver)) * speed / step
    error = BodyError(
        place=distance,
        speed=speed,
        angle=distance / arm,
        rate=speed / arm,
        slider_place=distance,
        slider_rate=speed,
        drive=2.0 * speed / step,
    )
    return {**motion.bounds(error, step), **dict.fromkeys(NORMAL_FORCES, loads)}


def _support_distance(solver: SequentialImpulse) -> float:
    """Returns the distance of the hindmost and the foremost support along the line [m]."""
    return solver.reach[1] - solver.reach[0]


def _contact_depth_bounds(
    problem: CapsuleProblem, motion: SampledMotion, solver: SequentialImpulse
) -> Bounds:
    """Returns bounds on the normal forces [N] from the overlap of the contacts.

    The contacts act where body and ground overlap, so that friction acts below C, the body's centre
    of mass, by the depth of the overlap. The moment of friction about C shifts load from one
    support to the other. It also changes the loads as much as a displacement of the slider would
    whose weight has the same moment.
    """
    capsule = motion.capsule
    moment = _friction_limit(problem) * motion.mass * solver.depth  # [N m]
    shifted_load = moment / _support_distance(solver)  # [N]
    slider_displacement = moment / (capsule.slider_mass * capsule.gravity)  # [m]
    load_change = slider_displacement * steepest_load(capsule)  # [N]
    return dict.fromkeys(NORMAL_FORCES, shifted_load + load_change)


def _straight_feet_bounds(
    motion: SampledMotion, solver: SequentialImpulse, coasting: bool
) -> Bounds:
    """Returns bounds on the error of feet that move straight in a step, not on a circle.

    If the motion is `coasting`, the error of the rotation moves C as well.
    """
    rates = np.abs(motion.rate)
    relative = float(rates.max() * solver.step) ** 2
    angle = relative * motion.count * float(np.trapezoid(rates, motion.times))
    rate = relative * float(rates.max())
    arm = support_arm(motion.capsule) * coasting
    return motion.bounds(BodyError(angle * arm, rate * arm, angle, rate), solver.step)
