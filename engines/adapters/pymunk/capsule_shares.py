"""What the capsule's models in pymunk add to the motion, apart from the step: bounds by reason.

Sweeps: where friction is asked for something else than the step before, the sweeps of one step
leave a share of what the velocity was to change by. They take the same from every foot, whatever
its load, so when a body that slid comes to rest and is held from the other side its light feet
reach their limit, and the last one has to stop it all: the share is what sweeps leave with one foot
gripping. It is the same for every friction, which only sets the unit of time. With no friction to
spare more sweeps hardly help: the share is below a hundredth (7e-3 with 50 sweeps, 5e-3 with 100).
As the slider goes on a foot at its limit gives what its load does, and the sweeps follow that too.
Rounding: a joint that closes what is open in one step makes a velocity of the last bit of a place.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.systems.capsule import ROUNDOFF, steepest_load
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.manoeuvres.repeated_line import RepeatedLine
from plumbob.analytic.systems.manoeuvres.residual_motion import ResidualMotion
from plumbob.analytic.systems.manoeuvres.slow_motion import SlowStroke
from plumbob.engines.adapters.pymunk.capsule_feet import few_feet_left_by_sweep
from plumbob.engines.adapters.pymunk.capsule_side import DEPTH, foot_reach

USED_UP = 0.02  # of friction to spare: below it, sweeps stall
STALLED = 1e-2  # of a velocity that sweeps leave where friction is used up
ROUNDINGS = 8  # on the way from places to a velocity
LOOKED_AT = 101  # times of the motion, to know its size
Shares = dict[str, dict[str, float]]


@dataclass(frozen=True)
class Demand:
    """What a motion asks of friction: how often another force, by how much per mass it changes
    [m/s^2], and the share of friction to spare while it holds or is overcome."""

    changes: int
    jump: float
    spare: float


def demand(motion: Any, grip: float) -> Demand:
    """Demand of a motion on friction that can give f g = `grip` [m/s^2], above zero."""
    if isinstance(motion, RepeatedLine):
        one = demand(motion.manoeuvre, grip)
        spare = min(one.spare, 1.0 - motion.fraction)
        return Demand((one.changes + 3) * motion.count, one.jump, spare)
    if isinstance(motion, LineManoeuvre):
        mu = motion.capsule.mass_ratio
        push, brake = mu * motion.w1, mu * motion.w2
        held, slid = abs(grip - brake) / grip, (push - grip) / grip
        # A push that is well above its threshold has every foot slip at once, at its limit.
        changes = 2 if slid > USED_UP else 3
        return Demand(changes, brake + grip + _shifted(motion, motion.stroke), min(slid, held))
    if isinstance(motion, SlowStroke):
        asked = 2 * motion.fraction * grip + _shifted(motion, motion.length)
        return Demand(5, asked, 1.0 - motion.fraction)
    return Demand(1, grip, 1.0) if isinstance(motion, ResidualMotion) else Demand(0, 0.0, 1.0)


def _shifted(motion: LineManoeuvre | SlowStroke, way: float) -> float:
    """Change of what a foot can give, per mass of all [m/s^2], as the slider goes `way` [m]."""
    capsule = motion.capsule
    shift = capsule.friction * steepest_load(capsule) * abs(way)
    return shift / (capsule.body_mass + capsule.slider_mass)


def left_by_sweeps(problem: CapsuleProblem, model: str, slowest: float, count: int) -> float:
    """Share of a velocity that `count` sweeps leave, `slowest` that of one while all grips."""
    capsule, motion = problem.setup.capsule, problem.motion
    grip = capsule.friction * capsule.gravity
    if model == "side" or not grip:
        return slowest**count
    left = max(few_feet_left_by_sweep(capsule, 1), slowest) ** count
    return max(left, STALLED) if demand(motion, grip).spare < USED_UP else left


def shares(
    problem: CapsuleProblem, duration: float, model: str, left: float, step: float
) -> Mapping[str, Mapping[str, float]]:
    """{observable: {reason: bound}} over `duration` [s], `left` what the sweeps of one step of
    `step` [s] leave of a velocity; no theory covers the friction of bare pivots."""
    found: Shares = {}
    _add(found, "rounding of places", _rounding(problem, duration, step))
    if model == "pivots":
        return found
    grip = problem.setup.capsule.friction * problem.setup.press
    if grip:
        _add(found, "sweeps", _sweeps(problem, duration, left, step, grip, model))
    if model == "side":
        hind, fore = foot_reach(problem.setup)
        tilted = grip * _mass(problem) * DEPTH / (fore - hind)
        _add(found, "depth of the feet", _each_support(problem, tilted))
    elif problem.setup.heading_rate:
        _add(found, "feet behind the turn", _behind(problem, step))
    return found


def _add(found: Shares, reason: str, bounds: Mapping[str, float]) -> None:
    for name, bound in bounds.items():
        found.setdefault(name, {})[reason] = bound


def _mass(problem: CapsuleProblem) -> float:
    return problem.setup.capsule.body_mass + problem.setup.capsule.slider_mass


def _arm(problem: CapsuleProblem) -> float:
    return math.sqrt(float(np.square(problem.setup.capsule.supports).sum()) / 3)


def _each_support(problem: CapsuleProblem, tilted: float) -> Mapping[str, float]:
    """A centre of pressure that is off by `tilted` [N] between the two feet, at the supports."""
    capsule = problem.setup.capsule
    hind, fore = foot_reach(problem.setup)
    moved = tilted * (fore - hind) * steepest_load(capsule) / capsule.slider_mass / capsule.gravity
    return {f"normal_force_{i}": tilted + moved for i in (1, 2, 3)}


def _sweeps(
    problem: CapsuleProblem, duration: float, left: float, step: float, grip: float, model: str
) -> Mapping[str, float]:
    asked = demand(problem.motion, grip)
    speed, spare = left * asked.jump * step, asked.spare * grip
    lasting = duration if speed >= spare * duration else speed / spare
    way = asked.changes * speed * (lasting + step)
    found = _spread(problem, way, 2 * speed, step, 2 * speed * step) | {"stroke_rate": speed}
    if model != "side":
        return found
    return found | {f"normal_force_{i}": found["friction_force"] for i in (1, 2, 3)}


def _rounding(problem: CapsuleProblem, duration: float, step: float) -> Mapping[str, float]:
    seen = problem.reference.observe(np.linspace(0.0, duration, LOOKED_AT))
    reach = [np.abs(seen[n]).max() for n in ("displacement", "stroke", "x", "y") if n in seen]
    size = math.hypot(*problem.setup.slider) + _arm(problem) + float(sum(reach))
    bit = ROUNDINGS * ROUNDOFF * size
    hind, fore = foot_reach(problem.setup)
    way, lever = bit * math.sqrt(duration / step), 1.0 + size / (fore - hind)
    loads = _mass(problem) * lever * bit / step**2
    both = _spread(problem, way, bit / step, step, way) | {"stroke_rate": bit / step}
    return {name: bound + loads * name.startswith("normal") for name, bound in both.items()}


def _spread(
    problem: CapsuleProblem, way: float, speed: float, step: float, slid: float
) -> dict[str, float]:
    """The same way [m] and speed [m/s] in every observable of the body, and `slid` [m] in those of
    the slider's place."""
    slope = steepest_load(problem.setup.capsule)
    return {
        **dict.fromkeys(("displacement", "sideways", "x", "y"), way),
        **dict.fromkeys(("velocity", "velocity_x", "velocity_y"), speed),
        "heading": way / _arm(problem),
        "heading_rate": speed / _arm(problem),
        "friction_force": _mass(problem) * speed / step,
        "stroke": slid,
        **{f"normal_force_{i}": slid * slope for i in (1, 2, 3)},
    }


def _behind(problem: CapsuleProblem, step: float) -> Mapping[str, float]:
    """A foot's velocity is a chord of its circle: what turns through an angle a in a step is off by
    a^2 of itself."""
    turned, motion = (problem.setup.heading_rate * step) ** 2, problem.motion
    size, rate = abs(motion.coasting.distance), abs(motion.coasting.rate)
    arm = max(math.hypot(*support) for support in problem.setup.capsule.supports)
    return {
        "heading": turned * size,
        "heading_rate": turned * rate,
        **dict.fromkeys(("x", "y"), turned * size * arm),
        **dict.fromkeys(("velocity_x", "velocity_y"), turned * rate * arm),
    }
