"""What the capsule's model in MuJoCo adds to a motion in the plane, apart from the step: bounds.

Where the N_i are not those of statics by dN_i (mujoco.capsule_riding), friction is off by
f dN_i at each support. What that does is bounded by a property of dry friction: at given normal
forces two motions of a body never part in velocity, measured by the kinetic energy of what they
differ by, for friction never works with that. So with e the root of twice that energy, and
directions d_i of slip,

    e' <= ((sum f dN_i d_i)^2/(M + m) + (sum f dN_i rho_i x d_i)^2/I)^(1/2),    rho_i = CA_i - mu r,

rates are off by e/I^(1/2) and e/(M + m)^(1/2), angle and place by their integrals. A support at
rest may be off in any direction. Creep of what is held, the solver's accuracy and the joints'
yielding come on top.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import ROUNDOFF
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.engines.adapters.mujoco.capsule_model import armature
from plumbob.engines.adapters.mujoco.capsule_riding import Riding, missing_loads, ridden
from plumbob.engines.adapters.mujoco.capsule_sag import shortest
from plumbob.engines.adapters.mujoco.contact_profiles import DAMPING, STIFFNESS, ContactProfile

LAG = 3.0  # contacts of finite damping lag behind statics, and swing: by this much of it in all


def shares(
    problem: CapsuleProblem, duration: float, chosen: ContactProfile, step: float
) -> Mapping[str, Mapping[str, float]]:
    """{observable: {reason: bound}} over `duration` [s], of contacts `chosen` that converge."""
    capsule = problem.setup.capsule
    both, count = capsule.body_mass + capsule.slider_mass, getattr(problem.motion, "count", 1)
    motion = ridden(problem, duration)
    sagging = missing_loads(problem, motion, chosen.sag_compliance(step) / both)
    jolts = _jolts(problem, motion, chosen.coupling() * both, step)
    off = math.sqrt(2.0 * float(chosen.options["tolerance"]) * both)
    wrong = {
        "sag of the contacts": LAG * _wrong(problem, motion, sagging),
        "slip felt by the normal": _wrong_at_most(problem, motion, jolts),
        "solver": np.full(motion.times.shape, off),
    }
    parts = {why: _grown(problem, motion, much, count) for why, much in wrong.items()}
    parts["creep"] = _creep(problem, motion, chosen.slip_compliance(step) / both, count)
    if problem.setup.plane_velocity is not None:
        parts["armature"] = _yielding(problem, motion, count)
    names = parts["creep"]
    return {name: {why: bounds[name] for why, bounds in parts.items()} for name in names}


def _wrong(problem: CapsuleProblem, motion: Riding, lost: Array) -> Array:
    """Bound on e' [kg^(1/2) m/s^2], shape (n,), of normal forces that lack `lost` [N], (3, n)."""
    grip, towards = problem.setup.capsule.friction, motion.directions
    force = (lost * towards).sum(axis=0)
    torque = (lost * (motion.arms.conjugate() * towards).imag).sum(axis=0)
    size = np.sqrt(np.abs(force) ** 2 / motion.mass + torque**2 / motion.inertia)
    held = np.where(towards == 0.0, np.abs(lost), 0.0)
    slides = np.where(motion.resting, 0.0, grip * size)
    return np.asarray(slides + _wrong_at_most(problem, motion, held))


def _wrong_at_most(problem: CapsuleProblem, motion: Riding, lost: Array) -> Array:
    """The same of normal forces that are off by `lost` [N] or less, shape (3, n), in any way."""
    reach = np.sqrt(1.0 / motion.mass + np.abs(motion.arms) ** 2 / motion.inertia)
    size = problem.setup.capsule.friction * (lost * reach).sum(axis=0)
    return np.asarray(np.where(motion.resting, 0.0, size))


def _jolts(problem: CapsuleProblem, motion: Riding, coupling: float, step: float) -> Array:
    """Normal forces [N], shape (3, n), altered by `coupling` f times slip speed over step: contacts
    take up what is steady, or grows steadily, and a jump of a support's acceleration is left to be
    so in some decays of theirs; never by more than the load there is."""
    capsule = problem.setup.capsule
    quick = np.gradient(np.abs(motion.slips), motion.times, axis=1)
    changed = np.abs(np.gradient(quick, motion.times, axis=1))
    changed[:, 0] += 2.0 * np.abs(quick[:, 0]) / (motion.times[1] - motion.times[0])  # from rest
    decay = LAG * step / (DAMPING * STIFFNESS)
    altered = coupling * capsule.friction * changed * decay
    return np.asarray(np.minimum(altered, capsule.weight))


def _grown(
    problem: CapsuleProblem, motion: Riding, wrong: Array, count: int
) -> Mapping[str, float]:
    """Bounds from e' <= `wrong` [kg^(1/2) m/s^2], shape (n,), where rest ends what there is; of
    `count` motions alike, each from rest."""
    times = motion.times
    spent = 0.5 * (wrong[1:] + wrong[:-1]) * np.diff(times)
    grown = np.append(0.0, np.cumsum(spent))
    energy = grown - np.maximum.accumulate(np.where(motion.resting, grown, 0.0))  # since rest
    turn, drift = energy / np.sqrt(motion.inertia), energy / math.sqrt(motion.mass)
    arm = problem.setup.capsule.mass_ratio * np.abs(motion.place)  # of C about the centre
    turned = float(np.trapezoid(turn, times)) * count
    way = float(np.trapezoid(motion.ground, times)) * count
    gone = float(np.trapezoid(drift, times)) * count + turned * (float(arm.max()) + way)
    speed = float((drift + arm * turn).max()) + turned * float(motion.ground.max())
    return _named(gone, speed, turned, float(turn.max()))


def _creep(
    problem: CapsuleProblem, motion: Riding, compliance: float, count: int
) -> Mapping[str, float]:
    """A support held against a force F creeps at `compliance` [m/s per N] times F or less."""
    speed = compliance * problem.setup.capsule.friction * problem.setup.capsule.weight
    arm, lasting = shortest(problem), float(motion.times[-1]) * count
    return _named(speed * lasting, speed, speed * lasting / arm, speed / arm)


def _yielding(problem: CapsuleProblem, motion: Riding, count: int) -> Mapping[str, float]:
    """The slider's way in the body is off by m/A of its way in space, and by the rounding of what
    drives it; the body's by no more than that."""
    setup = problem.setup
    part = setup.capsule.slider_mass / armature(setup) + 16 * ROUNDOFF
    rate = np.abs(motion.speed) + motion.ground + np.abs(motion.rate * motion.place)
    gone, speed = part * float(np.trapezoid(rate, motion.times)) * count, part * float(rate.max())
    arm = shortest(problem)
    return _named(gone, speed, gone / arm, speed / arm)


def _named(gone: float, speed: float, turned: float, rate: float) -> Mapping[str, float]:
    return {
        **dict.fromkeys(("x", "y"), gone),
        **dict.fromkeys(("velocity_x", "velocity_y"), speed),
        **dict.fromkeys(("heading", "body_angle"), turned),
        "heading_rate": rate,
    }
