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
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.errors.contact_models.model_error import (
    Bounds,
    ModelError,
    by_observable,
    radius_of_gyration,
    support_arm,
    with_drive,
)
from plumbob.analytic.errors.contact_models.sequential_impulse import ROUNDINGS, SequentialImpulse
from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import NORMAL_FORCES, Capsule, steepest_load
from plumbob.analytic.systems.capsule_setup import CapsuleProblem

USED_UP = 0.02  # of friction to spare, below which iterations stall: calibrated
STALLED = 1e-2  # fraction of a velocity left there, 7e-3 with 50 iterations: calibrated
SAMPLES = 2001  # of the motion, for its size
AT_SWITCH = 1e-9  # [s]: an event this near to a switch of the slider is caused by it


@dataclass(frozen=True)
class Demand:
    """Demand on the solver: how often forces change at once, by how much per mass friction's does,
    and the slider's while every foot sticks [m/s^2]; the fraction of friction to spare while it
    holds or is overcome; and how long the body slides on the residual of a foot's change [s]."""

    changes: int = 0
    jump: float = 0.0
    spare: float = 1.0
    push: float = 0.0
    sliding: float = 0.0


@dataclass(frozen=True)
class BodyError:
    """An error of C's own position [m] and velocity [m/s], of the heading [rad] and its rate
    [rad/s], and of the slider's place in the body [m] and its rate [m/s]."""

    place: float = 0.0
    speed: float = 0.0
    angle: float = 0.0
    rate: float = 0.0
    slid: float = 0.0
    slider_rate: float = 0.0


@dataclass(frozen=True)
class Run:
    """A motion of the capsule, simulated by a solver."""

    problem: CapsuleProblem
    duration: float  # [s]
    solver: SequentialImpulse

    @property
    def capsule(self) -> Capsule:
        """Whose motion it is."""
        return self.problem.setup.capsule

    @property
    def mass(self) -> float:
        """Of body and slider [kg]."""
        return self.capsule.body_mass + self.capsule.slider_mass

    @property
    def friction(self) -> float:
        """Friction limit per mass, f g [m/s^2]."""
        return self.capsule.friction * self.problem.setup.press

    @property
    def base(self) -> float:
        """Distance of the hindmost and the foremost support along the line [m]."""
        hind, fore = self.solver.reach
        return fore - hind

    @cached_property
    def demand(self) -> Demand:
        """The motion's demand on the solver."""
        motion = self.problem.motion
        return DEMANDS[motion.kind](motion, self.friction)

    @property
    def residual(self) -> float:
        """Fraction of a velocity that the iterations of a step leave, of a change of friction."""
        if self.solver.model == "side":
            return self.solver.residual
        left = self.solver.one_foot_residual
        return max(left, STALLED) if self.demand.spare < USED_UP else left

    @cached_property
    def times(self) -> Array:
        """Times [s] over the duration, or over the first of several turns."""
        motion = self.problem.motion
        once = motion.kind == "plane" and motion.count > 1
        return np.linspace(0.0, motion.period if once else self.duration, SAMPLES)

    @cached_property
    def observed(self) -> Mapping[str, Array]:
        """The exact motion."""
        return self.problem.reference.observe(self.times)

    def largest(self, *names: str) -> float:
        """The largest magnitudes of these observables, those that there are, added up."""
        return float(sum(np.abs(self.observed[n]).max() for n in names if n in self.observed))

    def gone(self, *names: str) -> float:
        """The way of these observables, to and fro."""
        count = self.problem.motion.count if self.problem.motion.kind == "plane" else 1
        parts = [np.diff(self.observed[name]) for name in names if name in self.observed]
        return count * float(np.sqrt(np.sum(np.square(parts), axis=0)).sum()) if parts else 0.0

    @cached_property
    def arm(self) -> float:
        """The largest distance of the combined centre from C [m]."""
        place = self.problem.setup.plane_place
        if place is None:
            reach = math.hypot(*self.problem.setup.slider) + self.largest("stroke")
        else:
            reach = float(np.hypot(*place(self.times).T).max())
        return self.capsule.mass_ratio * reach

    def bounds(self, error: BodyError) -> dict[str, float]:
        """The bound of every observable: C turns about the combined centre, and where it goes
        depends on the heading."""
        way = self.gone("displacement", "x", "y")
        fastest = self.largest("velocity") + math.hypot(
            self.largest("velocity_x"), self.largest("velocity_y")
        )
        place = error.angle * (self.arm + way) + error.place
        speed = error.rate * self.arm + error.angle * fastest + error.speed
        loads = error.slid * steepest_load(self.capsule)
        return {
            **dict.fromkeys(("displacement", "sideways", "x", "y"), place),
            **dict.fromkeys(("velocity", "velocity_x", "velocity_y"), speed),
            **dict.fromkeys(("heading", "body_angle"), error.angle),
            "heading_rate": error.rate,
            "friction_force": self.mass * error.speed / self.solver.step,
            "stroke": error.slid,
            "stroke_rate": error.slider_rate,
            **dict.fromkeys(NORMAL_FORCES, loads),
        }


def model_error(problem: CapsuleProblem, duration: float, solver: SequentialImpulse) -> ModelError:
    """{observable: {reason: bound}} over `duration` [s] of all mechanisms of the solver's model;
    empty for bare pivots in the plane, whose friction is not Coulomb's."""
    if solver.model == "pivots" and problem.motion.kind == "plane":
        return {}
    run = Run(problem, duration, solver)
    bounds = {reason: bound(run) for reason, bound in MECHANISMS[solver.model]}
    capsule, step = problem.setup.capsule, solver.step
    return by_observable({why: with_drive(terms, capsule, step) for why, terms in bounds.items()})


def _line(motion: Any, friction: float) -> Demand:
    ratio = motion.capsule.mass_ratio
    push, brake = ratio * motion.w1, ratio * motion.w2
    held, slid = abs(friction - brake) / friction, (push - friction) / friction
    # A push that is well above its threshold has every foot slip at once, at its limit.
    changes = 2 if slid > USED_UP else 3
    return Demand(changes, brake + friction + _load_change(motion, motion.stroke), min(slid, held))


def _repeated_line(motion: Any, friction: float) -> Demand:
    single = _line(motion.single, friction)
    spare = min(single.spare, 1.0 - motion.fraction)  # of the slow return
    return Demand((single.changes + 3) * motion.count, single.jump, spare)


def _stroke(motion: Any, friction: float) -> Demand:
    jump = 2 * motion.fraction * friction + _load_change(motion, motion.length)
    return Demand(5, jump, 1.0 - motion.fraction)


def _load_change(motion: Any, way: float) -> float:
    """Change of the friction limit of a foot, per mass of all [m/s^2], as the slider goes `way`
    [m]."""
    capsule = motion.capsule
    shift = capsule.friction * steepest_load(capsule) * abs(way)
    return float(shift / (capsule.body_mass + capsule.slider_mass))


def _plane(motion: Any, friction: float) -> Demand:
    single = motion.single
    times = np.clip(single.path.breakpoints, 0.0, None)
    strongest = float(np.hypot(*single.path.kinematics(times)[2].T).max())
    changes, push = len(single.events) + times.size, single.capsule.mass_ratio * strongest
    sliding = motion.count * _sliding(single, times)
    return Demand(motion.count * changes, friction, 1.0, push, sliding)


def _sliding(single: Any, switches: Any) -> float:
    """Time [s] from each event in which a foot sticks or slips, other than at a switch of the
    slider, to the rest that follows; and the longest slide that a switch starts.

    A push that begins in the last half per cent of a step starts the body with the residual: of a
    plan's some ninety pushes at most one or two do. Such a step demands a push of at most the
    friction, or no foot would stick, and for friction too: the slide counts twice.
    """
    sliding, longest, resting = 0.0, 0.0, single.rest_time
    modes_before = (None, *(event.mode for event in single.events[:-1]))
    for event, before in zip(reversed(single.events), reversed(modes_before), strict=True):
        if event.mode == "rest":
            resting = event.time
        elif event.mode == "pivot" or np.abs(switches - event.time).min() > AT_SWITCH:
            sliding += resting - event.time
        elif before == "rest":
            longest = max(longest, resting - event.time)
    return float(sliding + 2.0 * longest)


def _iterations(run: Run) -> Bounds:
    """A velocity left at each change decays under the friction to spare, or lasts to the end. A
    switch inside a step changes the velocity in that step by a part, in the next by the rest: of
    the slider's push, too, something is left for two steps."""
    if not run.friction and run.problem.motion.kind != "plane":
        return {}
    demand, step = run.demand, run.solver.step
    stopped, spare = run.residual * demand.jump * step, demand.spare * run.friction
    left = stopped + run.solver.residual * demand.push * step
    lasting = min(stopped / spare, run.duration) if spare else run.duration * bool(stopped)
    lasting += (2.0 if demand.push else 1.0) * step
    way = demand.changes * left * lasting + stopped * demand.sliding
    # Iterations reduce the kinetic energy: a residual rate is a residual speed over the radius of
    # gyration, or over the supports' arm if that is shorter.
    radius, speed = min(support_arm(run.capsule), radius_of_gyration(run.capsule)), 2.0 * left
    error = BodyError(way, speed, way / radius, speed / radius, speed * step, left)
    bounds = run.bounds(error)
    if run.solver.model == "side":  # whose normal forces are the contacts' own impulses
        bounds |= dict.fromkeys(NORMAL_FORCES, bounds["friction_force"])
    return bounds


def _coming_to_rest(run: Run) -> Bounds:
    """Residual of the iterations as a body on bare pivots comes to rest: some of them are at their
    limits where it stops next to the end of a step."""
    return _iterations(run) if run.problem.motion.kind == "coasting" else {}


def _rounding(run: Run) -> Bounds:
    """See the module's text."""
    arm, step = support_arm(run.capsule), run.solver.step
    reach = run.gone("displacement", "x", "y") + run.largest("stroke")
    size = math.hypot(*run.problem.setup.slider) + arm + reach
    bit = ROUNDINGS * ROUNDOFF * size
    way, speed = bit * math.sqrt(run.duration / step), bit / step
    bounds = run.bounds(BodyError(way, speed, way / arm, speed / arm, way, speed))
    loads = run.mass * (1.0 + size / run.base) * speed / step
    return {name: bound + loads * (name in NORMAL_FORCES) for name, bound in bounds.items()}


def _contact_depth(run: Run) -> Bounds:
    """Friction acts below C by the overlap: its moment moves load from one foot to the other, and
    the centre of pressure that the supports carry."""
    tilted = run.friction * run.mass * run.solver.depth / run.base
    moved = tilted * run.base * steepest_load(run.capsule)
    moved /= run.capsule.slider_mass * run.capsule.gravity
    return dict.fromkeys(NORMAL_FORCES, tilted + moved)


def _straight_feet(run: Run) -> Bounds:
    """A foot moves straight and not on a circle."""
    relative = (run.largest("heading_rate") * run.solver.step) ** 2
    if not relative:
        return {}
    angle, rate = relative * run.gone("heading"), relative * run.largest("heading_rate")
    arm = support_arm(run.capsule) if run.problem.motion.kind == "coasting" else 0.0
    return run.bounds(BodyError(angle * arm, rate * arm, angle, rate))


DEMANDS: Mapping[str, Callable[[Any, float], Demand]] = MappingProxyType(
    {
        "line": _line,
        "repeated-line": _repeated_line,
        "stroke": _stroke,
        "coasting": lambda motion, friction: Demand(1, friction),
        "hold": lambda motion, friction: Demand(),
        "plane": _plane,
    }
)
Mechanism = tuple[str, Callable[[Run], Bounds]]
ROUNDING: Mechanism = ("rounding of positions", _rounding)
ITERATIONS: Mechanism = ("solver iterations", _iterations)
MECHANISMS: Mapping[str, tuple[Mechanism, ...]] = MappingProxyType(
    {
        # Their friction is Coulomb's where the body turns about C; elsewhere no bound is known.
        "pivots": (ROUNDING, ("solver iterations", _coming_to_rest)),
        "feet": (ROUNDING, ITERATIONS, ("straight steps of feet", _straight_feet)),
        "side": (ROUNDING, ITERATIONS, ("contact depth", _contact_depth)),
    }
)
