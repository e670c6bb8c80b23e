"""Model errors of sequential impulses on motions with a closed form: bounds by reason.

Solver iterations: where friction has to give another force than in the step before, the iterations
of one step leave a fraction of the change of velocity. They leave the same at every foot, whatever
its load, so when a sliding body comes to rest and is held from the other side its light feet reach
their friction limits, and the fraction is bounded by the convergence factor with one sticking foot.
It is the same for every friction, which only sets the unit of time. Where friction has nothing to
spare, more iterations hardly help. As the slider moves on, the load of a foot at its limit changes,
and the iterations follow that too.
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
    support_arm,
    with_drive,
)
from plumbob.analytic.errors.contact_models.sequential_impulse import ROUNDINGS, SequentialImpulse
from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.systems.capsule import NORMAL_FORCES, steepest_load
from plumbob.analytic.systems.capsule_setup import CapsuleProblem

USED_UP = 0.02  # of friction to spare, below which iterations stall: calibrated
STALLED = 1e-2  # fraction of a velocity left there, 7e-3 with 50 iterations: calibrated
SAMPLES = 101  # of the motion, for its size


@dataclass(frozen=True)
class FrictionDemand:
    """Demand on friction: how often its force changes at once, by how much per mass [m/s^2], and
    the fraction of friction to spare while it holds or is overcome."""

    changes: int = 0
    jump: float = 0.0
    spare: float = 1.0


@dataclass(frozen=True)
class LineRun:
    """A motion of the capsule with a closed form, simulated by a solver."""

    problem: CapsuleProblem
    duration: float  # [s]
    solver: SequentialImpulse

    @property
    def mass(self) -> float:
        """Of body and slider [kg]."""
        capsule = self.problem.setup.capsule
        return capsule.body_mass + capsule.slider_mass

    @property
    def step(self) -> float:
        """Of the solver [s]."""
        return self.solver.step

    @property
    def arm(self) -> float:
        """Root mean square distance of the supports from C [m]."""
        return support_arm(self.problem.setup.capsule)

    @property
    def base(self) -> float:
        """Distance of the hindmost and the foremost support along the line [m]."""
        hind, fore = self.solver.reach
        return fore - hind

    @property
    def friction(self) -> float:
        """Friction limit per mass, f g [m/s^2]."""
        return self.problem.setup.capsule.friction * self.problem.setup.press

    @cached_property
    def demand(self) -> FrictionDemand:
        """The motion's demand on friction, where there is any."""
        motion = self.problem.motion
        return DEMANDS[motion.kind](motion, self.friction)

    @property
    def residual(self) -> float:
        """Fraction of a velocity that the iterations of a step leave."""
        if self.solver.model == "side":
            return self.solver.residual
        left = self.solver.one_foot_residual
        return max(left, STALLED) if self.demand.spare < USED_UP else left


def model_error(problem: CapsuleProblem, duration: float, solver: SequentialImpulse) -> ModelError:
    """{observable: {reason: bound}} over `duration` [s] of all mechanisms of the solver's model."""
    run = LineRun(problem, duration, solver)
    bounds = {reason: bound(run) for reason, bound in MECHANISMS[solver.model]}
    capsule, step = problem.setup.capsule, solver.step
    return by_observable({why: with_drive(terms, capsule, step) for why, terms in bounds.items()})


def _line(motion: Any, friction: float) -> FrictionDemand:
    ratio = motion.capsule.mass_ratio
    push, brake = ratio * motion.w1, ratio * motion.w2
    held, slid = abs(friction - brake) / friction, (push - friction) / friction
    # A push that is well above its threshold has every foot slip at once, at its limit.
    changes = 2 if slid > USED_UP else 3
    jump = brake + friction + _load_change(motion, motion.stroke)
    return FrictionDemand(changes, jump, min(slid, held))


def _repeated_line(motion: Any, friction: float) -> FrictionDemand:
    single = _line(motion.single, friction)
    spare = min(single.spare, 1.0 - motion.fraction)  # of the slow return
    return FrictionDemand((single.changes + 3) * motion.count, single.jump, spare)


def _stroke(motion: Any, friction: float) -> FrictionDemand:
    jump = 2 * motion.fraction * friction + _load_change(motion, motion.length)
    return FrictionDemand(5, jump, 1.0 - motion.fraction)


def _coasting(motion: Any, friction: float) -> FrictionDemand:
    return FrictionDemand(1, friction)


def _hold(motion: Any, friction: float) -> FrictionDemand:
    return FrictionDemand()


def _load_change(motion: Any, way: float) -> float:
    """Change of the friction limit of a foot, per mass of all [m/s^2], as the slider goes `way`
    [m]."""
    capsule = motion.capsule
    shift = capsule.friction * steepest_load(capsule) * abs(way)
    return float(shift / (capsule.body_mass + capsule.slider_mass))


def _iterations(run: LineRun) -> Bounds:
    """A velocity left at each change decays under the friction to spare, or lasts to the end."""
    if not run.friction:
        return {}
    demand, step = run.demand, run.step
    speed, spare = run.residual * demand.jump * step, demand.spare * run.friction
    lasting = run.duration if speed >= spare * run.duration else speed / spare
    way = demand.changes * speed * (lasting + step)
    bounds = {**_everywhere(run, way, 2 * speed, 2 * speed * step), "stroke_rate": speed}
    if run.solver.model == "side":  # whose normal forces are the contacts' own impulses
        bounds |= dict.fromkeys(NORMAL_FORCES, bounds["friction_force"])
    return bounds


def _coming_to_rest(run: LineRun) -> Bounds:
    """Residual of the iterations as a body on bare pivots comes to rest: some of them are at their
    limits where it stops next to the end of a step."""
    return _iterations(run) if run.problem.motion.kind == "coasting" else {}


def _rounding(run: LineRun) -> Bounds:
    """A joint that closes its opening in one step turns the last bit of a position into a velocity,
    in each step again: positions make a random walk."""
    problem, step = run.problem, run.step
    observed = problem.reference.observe(np.linspace(0.0, run.duration, SAMPLES))
    reach = [
        np.abs(observed[n]).max() for n in ("displacement", "stroke", "x", "y") if n in observed
    ]
    size = math.hypot(*problem.setup.slider) + run.arm + float(sum(reach))
    bit = ROUNDINGS * ROUNDOFF * size
    way, lever = bit * math.sqrt(run.duration / step), 1.0 + size / run.base
    loads = run.mass * lever * bit / step**2
    both = {**_everywhere(run, way, bit / step, way), "stroke_rate": bit / step}
    return {name: bound + loads * (name in NORMAL_FORCES) for name, bound in both.items()}


def _contact_depth(run: LineRun) -> Bounds:
    """Friction acts below C by the overlap: its moment moves load from one foot to the other, and
    the centre of pressure that the supports carry."""
    tilted = run.friction * run.mass * run.solver.depth / run.base
    capsule = run.problem.setup.capsule
    moved = tilted * run.base * steepest_load(capsule) / capsule.slider_mass / capsule.gravity
    return dict.fromkeys(NORMAL_FORCES, tilted + moved)


def _straight_feet(run: LineRun) -> Bounds:
    """A foot moves straight and not on a circle: a turn by an angle a in a step has the relative
    error a^2 at most."""
    setup, motion = run.problem.setup, run.problem.motion
    if not setup.heading_rate:
        return {}
    relative = (setup.heading_rate * run.step) ** 2
    turned = relative * abs(motion.coasting.distance)
    rate = relative * abs(motion.coasting.rate)
    arm = max(math.hypot(*support) for support in setup.capsule.supports)
    return {
        "heading": turned,
        "heading_rate": rate,
        **dict.fromkeys(("x", "y"), turned * arm),
        **dict.fromkeys(("velocity_x", "velocity_y"), rate * arm),
    }


def _everywhere(run: LineRun, way: float, speed: float, slid: float) -> dict[str, float]:
    """The same way [m] and speed [m/s] in every observable of the body, and `slid` [m] in those of
    the slider's place."""
    slope = steepest_load(run.problem.setup.capsule)
    return {
        **dict.fromkeys(("displacement", "sideways", "x", "y"), way),
        **dict.fromkeys(("velocity", "velocity_x", "velocity_y"), speed),
        "heading": way / run.arm,
        "heading_rate": speed / run.arm,
        "friction_force": run.mass * speed / run.step,
        "stroke": slid,
        **dict.fromkeys(NORMAL_FORCES, slid * slope),
    }


Demander = Callable[[Any, float], FrictionDemand]
DEMANDS: Mapping[str, Demander] = MappingProxyType(
    {
        "line": _line,
        "repeated-line": _repeated_line,
        "stroke": _stroke,
        "coasting": _coasting,
        "hold": _hold,
    }
)
Mechanism = tuple[str, Callable[[LineRun], Bounds]]
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
