"""What the capsule's model in MuJoCo adds to the motion, apart from the step: bounds by reason.

Friction that holds a force creeps. The slider's joint follows its control but for m/A of what else
accelerates it. The solver stops when its cost, (M + m) a^2/2, falls by less than its tolerance. And
contacts yield (plumbob.engines.adapters.mujoco.capsule_sag).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from plumbob.analytic.systems.capsule import ROUNDOFF, load_slopes
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.manoeuvres.line_reference import condition_number
from plumbob.analytic.systems.manoeuvres.residual_motion import ResidualMotion
from plumbob.engines.adapters.mujoco import capsule_reduced
from plumbob.engines.adapters.mujoco.capsule_model import armature
from plumbob.engines.adapters.mujoco.capsule_sag import (
    POINTS,
    coupling_bounds,
    height_bounds,
    sag_bounds,
    shortest,
)
from plumbob.engines.adapters.mujoco.contact_profiles import convergent, profile

SHIPPED = 1e-8  # tolerance of the solver, where a model keeps it
Shares = Mapping[str, Mapping[str, float]]


def shares(
    problem: CapsuleProblem, duration: float, settings: Mapping[str, Any], step: float
) -> Shares:
    """{observable: {reason: bound}} over `duration` [s]; empty where no theory covers contacts."""
    reduced = settings.get("model") == "reduced"
    if settings.get("model") == "planar" or not (reduced or convergent(settings)):
        return {}
    capsule, count = problem.setup.capsule, getattr(problem.motion, "count", 1)
    both = capsule.body_mass + capsule.slider_mass
    if reduced:
        creep = capsule_reduced.creep(step) / both
    else:
        creep = profile(settings).slip_compliance(step) / both
    found: dict[str, dict[str, float]] = {}
    _add(found, "creep", _creep(problem, duration, creep, step))
    if problem.setup.relative_velocity is not None:
        _add(found, "armature", _yielding(problem, duration, count))
    accuracy = SHIPPED if reduced else float(profile(settings).options["tolerance"])
    _add(found, "solver", _solver(problem, duration, math.sqrt(2 * accuracy), step, count))
    if not reduced:
        sag = profile(settings).sag_compliance(step) / both
        height = float(settings.get("height", 0.0))
        _add(found, "sag of the contacts", sag_bounds(problem, duration, sag, step, count, height))
        coupled = profile(settings).coupling() * both
        _add(found, "slip felt by the normal", coupling_bounds(problem, coupled, sag, step))
        _add(found, "height of the centre of mass", height_bounds(problem, height))
    return found


def _add(found: dict[str, dict[str, float]], reason: str, bounds: Mapping[str, float]) -> None:
    for name, bound in bounds.items():
        found.setdefault(name, {})[reason] = bound


def _creep(
    problem: CapsuleProblem, duration: float, compliance: float, step: float
) -> Mapping[str, float]:
    """A body held against a force F creeps at `compliance` [m/s per N] times F or less."""
    capsule = problem.setup.capsule
    if isinstance(problem.motion, ResidualMotion) or not capsule.friction:
        return {}
    speed = compliance * capsule.friction * capsule.weight
    arm = shortest(problem)
    way = {"displacement": speed * duration, "sideways": speed * duration}
    started = (capsule.body_mass + capsule.slider_mass) * speed / step
    way |= {"velocity": speed, "friction_force": started}
    return {**way, "heading": speed * duration / arm}


def _solver(
    problem: CapsuleProblem, duration: float, off: float, step: float, count: int
) -> Mapping[str, float]:
    """Accelerations that are `off` by so much [m/s^2]: for good while the body slides, until the
    next step while friction asks for rest."""
    capsule, motion = problem.setup.capsule, problem.motion
    slid = _sliding(motion, duration)
    way = off * (0.5 * slid**2 * count + step * duration)
    speed = off * (slid + step)
    arm = shortest(problem)
    both = capsule.body_mass + capsule.slider_mass
    return {
        **dict.fromkeys(("displacement", "sideways", "x", "y"), way),
        **dict.fromkeys(("velocity", "velocity_x", "velocity_y"), speed),
        "heading": way / arm,
        "heading_rate": speed / arm,
        "friction_force": both * (off + speed / step),
    }


def _sliding(motion: Any, duration: float) -> float:
    """How long the body slides at a time [s]."""
    line = getattr(motion, "manoeuvre", motion)
    if isinstance(line, LineManoeuvre):
        return line.t_star
    return float(motion.duration) if isinstance(motion, ResidualMotion) else 0.0


def _yielding(problem: CapsuleProblem, duration: float, count: int) -> Mapping[str, float]:
    """The slider's way in the body is off by m/A of its way in space."""
    setup, motion = problem.setup, problem.motion
    part = setup.capsule.slider_mass / armature(setup)
    times = np.linspace(0.0, duration, POINTS)
    seen = problem.reference.observe(times)
    way = float((np.abs(seen["stroke"]) + np.abs(seen["displacement"])).max())
    rate = float((np.abs(seen["stroke_rate"]) + np.abs(seen["velocity"])).max())
    line, moved, late = getattr(motion, "manoeuvre", motion), 0.0, 0.0
    if isinstance(line, LineManoeuvre):
        moved = condition_number(line) * abs(line.displacement) * count
        late = (
            4 * ROUNDOFF * duration * line.w1
        )  # velocity left by times rounded ever more coarsely
    slope = float(np.abs(load_slopes(setup.capsule, setup.direction)).max())
    return {
        "stroke": part * way + late * duration,
        "stroke_rate": (part + 16 * ROUNDOFF) * rate,
        "displacement": part * moved,
        "velocity": part * rate,
        **{f"normal_force_{i}": (part * way + late * duration) * slope for i in (1, 2, 3)},
    }
