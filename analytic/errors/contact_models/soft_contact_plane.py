"""Model errors of soft contacts on a motion in the plane without a closed form: bounds.

Deflection dynamics. The deflections c N_i, affine in the slider's place r, put C at a height z and
give the body's plane a gradient g, so the slider has the height q = z + g.r. With F_i the friction,
a and b the horizontal accelerations of C and Q, plane vectors as complex numbers in body axes, the
loads of statics lack

    sum dN_i     = M z'' + m q''
    sum dN_i A_i = m q'' r + P - (q - z) m b - z sum F_i + sum z_i F_i/2,
    P = I_a (g'' + 2i w g' + (i w' - w^2) g) + J (w^2 g - i w' g - i w g')

where w is the body's rate and I_a its inertia across: vertical inertia, gyroscopic moments, and
moments of horizontal forces at their heights. A contact acts halfway down its depth.

Contraction. Where the N_i differ from those of statics by dN_i, friction differs by f dN_i at each
support. What that does is bounded by a property of dry friction: at given normal forces the
velocities of two motions of a body never diverge, measured by the kinetic energy of their
difference, since friction does no positive work on that. So with e the root of twice that energy,
and directions d_i of slip,

    e' <= ((sum f dN_i d_i)^2/(M + m) + (sum f dN_i rho_i x d_i)^2/I)^(1/2),    rho_i = CA_i - mu r,

the errors of the rates are e/I^(1/2) and e/(M + m)^(1/2), of angle and place their integrals. The
friction of a support that sticks may differ in any direction. The error resets where the exact
motion and that of the steps are both at rest.
Derivations: THEORY.md, section 9.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any, cast

import numpy as np

from plumbob.analytic.errors.contact_models import soft_contact
from plumbob.analytic.errors.contact_models.added_inertia import slider_in_the_plane
from plumbob.analytic.errors.contact_models.model_error import (
    Bounds,
    ModelError,
    by_observable,
)
from plumbob.analytic.errors.contact_models.soft_contact import (
    DEPTH_ROUNDINGS,
    NormalContact,
    SoftContact,
    load_fraction_slopes,
    shortest_arm,
)
from plumbob.analytic.errors.sliding_motion.plane_errors import MOST_STEPS
from plumbob.analytic.errors.sliding_motion.plane_steps import trajectory
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import (
    NORMAL_FORCES,
    ROUNDOFF,
    Capsule,
    load_fractions,
    normal_forces,
    steepest_load,
)
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.slider_path import SliderPath
from plumbob.analytic.systems.three_points.equations import Complex
from plumbob.analytic.systems.three_points.friction import Start, three_point_motion
from plumbob.analytic.systems.three_points.reference import PlaneReference

PLACES = 33  # in each piece of the slider's motion, for what is smooth within one
LATE = 257  # after the last one, where friction alone acts
STILL = 1e-9  # of the largest slip: below it a support sticks


@dataclass(frozen=True)
class PlaneMotion:
    """The exact motion at times [s], shape (n,), the slider's part of it as x + iy in body axes,
    arms CA_i - mu r and slips of the supports, shape (3, n)."""

    times: Array
    place: Complex  # r [m]
    speed: Complex  # r' [m/s]
    push: Complex  # r'' [m/s^2]
    rate: Array  # of the body [rad/s]
    ground: Array  # |velocity of C| [m/s]
    mass: float  # M + m [kg]
    inertia: Array  # about the combined centre [kg m^2], shape (n,)
    arms: Complex
    slips: Complex  # [m/s]; zero where a support sticks
    limits: Array  # friction limits f N_i [N], shape (3, n)
    stepping: Any = False  # whether the steps' body moves, shape (n,)

    @property
    def resting(self) -> Any:
        """Whether body and slider are at rest, and the steps' body too, shape (n,)."""
        still = (np.abs(self.slips).max(axis=0) == 0.0) & (self.speed == 0.0)
        return still & ~np.asarray(self.stepping)

    @property
    def directions(self) -> Complex:
        """Of the slips; zero where a support sticks."""
        size = np.abs(self.slips)
        return self.slips / np.where(size > 0.0, size, 1.0)


@dataclass(frozen=True)
class QuasiStatic:
    """Deflections under the loads of statics along a motion, and their derivatives."""

    depths: Array  # of the supports [m], shape (3, n)
    height: Array  # z of C [m], shape (n,)
    height_second: Array  # z'' [m/s^2]
    gradient: Complex  # g of the body's plane
    gradient_rate: Complex  # g' [1/s]
    gradient_second: Complex  # g'' [1/s^2]


def model_error(problem: CapsuleProblem, duration: float, contact: SoftContact) -> ModelError:
    """{observable: {reason: bound}} of a motion in the plane over `duration` [s]; raises ValueError
    for a contact without a normal."""
    if contact.normal is None:
        raise ValueError("a motion in the plane has no theory of joint friction")
    capsule = problem.setup.capsule
    motion, count = plane_motion(problem, duration), problem.motion.count
    motion = replace(motion, stepping=_stepping(problem, motion.times, duration, contact))
    lost = missing_loads(problem, motion, contact.normal.compliance, contact.normal.tilt_inertia)
    coupled = _coupled_loads(capsule, motion, contact.normal, contact.step)
    accuracy = math.sqrt(2.0 * contact.solver_tolerance * motion.mass)
    rates = {
        "contact deflection": soft_contact.QUASI_STATIC_FACTOR * _growth(capsule, motion, lost),
        "tangential–normal coupling": _growth_at_most(capsule, motion, coupled),
        "solver": np.full(motion.times.shape, accuracy),
    }
    parts = {why: _grown(capsule, motion, rate, count) for why, rate in rates.items()}
    parts["drift of stiction"] = _stiction_drift(problem, motion, contact, count)
    if problem.setup.plane_velocity is not None:
        parts["armature"] = _slider_armature(problem, motion, contact, count)
    loads = {
        "contact deflection": soft_contact.OVERSHOOT_FACTOR * np.abs(lost).max(axis=1),
        "tangential–normal coupling": coupled.max(axis=1),
        "solver": np.full(3, math.sqrt(2.0 * contact.solver_tolerance) * motion.mass),
        "rounding of depths": np.full(3, _rounded_depths(capsule, contact.normal)),
    }
    for why, bounds in loads.items():
        parts[why] = {
            **parts.get(why, {}),
            **dict(zip(NORMAL_FORCES, bounds.tolist(), strict=True)),
        }
    return by_observable(parts)


def _rounded_depths(capsule: Capsule, normal: NormalContact) -> float:
    reach = max(math.hypot(*support) for support in capsule.supports)
    return DEPTH_ROUNDINGS * ROUNDOFF * reach / normal.compliance


def plane_motion(problem: CapsuleProblem, duration: float) -> PlaneMotion:
    """The motion, or the first of several equal ones, until `duration` [s], finely in each
    piece."""
    motion, setup = problem.motion, problem.setup
    start = Start(velocity=setup.velocity, angular_velocity=setup.heading_rate)
    end = duration if motion.count == 1 else min(duration, motion.period)
    return _sampled(setup.capsule, motion.single.path, start, end)


def _stepping(problem: CapsuleProblem, times: Array, duration: float, contact: SoftContact) -> Any:
    """Whether the steps' body moves at `times` [s], shape (n,): the residual of a turn continues
    until friction has stopped that too. False where the steps are too many to be taken."""
    steps = round(duration / contact.step)
    if steps > MOST_STEPS:
        return False
    begun = cast(PlaneReference, problem.reference).begun
    driven = (problem.setup.capsule, problem.motion.path, begun)
    rows = trajectory(*driven, contact.integrator, contact.step, steps)
    turned = max(math.hypot(*support) for support in problem.setup.capsule.supports) * rows[:, 5]
    moved = np.abs(rows[:, 3]) + np.abs(rows[:, 4]) + np.abs(turned)
    moving = moved > STILL * moved.max()
    return moving[np.minimum(np.rint(times / contact.step).astype(int), steps)]


@lru_cache(maxsize=8)  # the same for every method and step of a scene
def _sampled(capsule: Capsule, path: SliderPath, start: Start, end: float) -> PlaneMotion:
    times = _times(path, end)
    place, speed, push = (_complex(part) for part in path.kinematics(times))
    pose = three_point_motion(capsule, path, start).at(times)
    ground = _complex(pose.velocity) * np.exp(-1j * pose.heading)
    supports, mu = _complex(np.asarray(capsule.supports)), capsule.mass_ratio
    slips = np.asarray(ground + 1j * pose.angular_velocity * supports[:, None])
    slips = np.where(np.abs(slips) > STILL * np.abs(slips).max(), slips, 0.0)
    loads = normal_forces(capsule, np.stack([place.real, place.imag], axis=-1)).T
    return PlaneMotion(
        times,
        place,
        speed,
        push,
        pose.angular_velocity,
        np.abs(ground),
        mass=capsule.body_mass + capsule.slider_mass,
        inertia=capsule.inertia + mu * capsule.body_mass * np.abs(place) ** 2,
        arms=supports[:, None] - mu * place,
        slips=slips,
        limits=capsule.friction * loads,
    )


def _times(path: SliderPath, end: float) -> Array:
    """Times until `end` [s], shape (n,): PLACES in each piece of the path, LATE after the last."""
    edges = np.unique(np.append(np.minimum(path.breakpoints, end), [0.0, end]))
    counts = [PLACES] * (len(edges) - 2) + [LATE]
    parts = [
        np.linspace(a, b, n, endpoint=False)
        for (a, b), n in zip(pairwise(edges.tolist()), counts, strict=True)
    ]
    return np.append(np.concatenate(parts), end)


def _complex(vectors: Array) -> Complex:
    """Plane vectors, shape (n, 2), as x + iy."""
    return vectors[:, 0] + 1j * vectors[:, 1]


def missing_loads(
    problem: CapsuleProblem, motion: PlaneMotion, compliance: float, tilt_inertia: float
) -> Array:
    """dN_i [N], shape (3, n), of contacts of a `compliance` [m/N] under a body whose inertia across
    the vertical is `tilt_inertia` [kg m^2] (module docstring)."""
    capsule = problem.setup.capsule
    bent = _quasi_static(problem, motion, compliance)
    lifted, over = _slider_height(motion, bent)
    friction = -motion.limits * motion.directions
    dragged = friction.sum(axis=0)
    spun, drawn = _horizontal(capsule, motion, friction)
    total = capsule.body_mass * bent.height_second + capsule.slider_mass * lifted
    moment = capsule.slider_mass * lifted * motion.place
    moment += _gyration(motion.rate, spun, bent, tilt_inertia, capsule.inertia)
    moment += -over * drawn - bent.height * dragged + 0.5 * (bent.depths * friction).sum(axis=0)
    tilting, central = _tilting(problem), load_fractions(capsule, np.zeros(2))
    return np.outer(central, total) + (tilting.conjugate()[:, None] * moment).real


def _tilting(problem: CapsuleProblem) -> Complex:
    """Slopes of the load fractions as complex numbers [1/m], shape (3,)."""
    return np.asarray(load_fraction_slopes(problem) @ [1.0, 1j])


def _quasi_static(problem: CapsuleProblem, motion: PlaneMotion, compliance: float) -> QuasiStatic:
    """Deflections of contacts of a `compliance` [m/N] under the loads of statics."""
    capsule = problem.setup.capsule
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    here, ahead, aside = -compliance * normal_forces(capsule, corners)
    tilting, central = _tilting(problem), load_fractions(capsule, np.zeros(2))

    def linear(vector: Complex) -> tuple[Array, Array, Complex]:
        """Change of depths (3, n), of C's height and of the gradient with r by `vector`."""
        depths = np.outer(ahead - here, vector.real) + np.outer(aside - here, vector.imag)
        return depths, central @ depths, tilting @ depths

    depths, height, gradient = linear(motion.place)
    _, _, gradient_rate = linear(motion.speed)
    _, height_second, gradient_second = linear(motion.push)
    return QuasiStatic(
        depths=depths + here[:, None],
        height=height + central @ here,
        height_second=height_second,
        gradient=gradient + tilting @ here,
        gradient_rate=gradient_rate,
        gradient_second=gradient_second,
    )


def _slider_height(motion: PlaneMotion, bent: QuasiStatic) -> tuple[Array, Array]:
    """q'' [m/s^2] of the slider, and its height over C, q - z = g.r [m], each of shape (n,)."""
    r, v, w = motion.place, motion.speed, motion.push
    curved = bent.gradient_second.conjugate() * r + 2.0 * bent.gradient_rate.conjugate() * v
    lifted = bent.height_second + (curved + bent.gradient.conjugate() * w).real
    return lifted, (bent.gradient.conjugate() * r).real


def _horizontal(capsule: Capsule, motion: PlaneMotion, friction: Complex) -> tuple[Array, Complex]:
    """Angular acceleration of the body [rad/s^2] and the horizontal force on the slider [N] under
    the `friction` F_i [N], shape (3, n): m b in the module docstring."""
    r, rate, mu = motion.place, motion.rate, capsule.mass_ratio
    torque = (motion.arms.conjugate() * friction).imag.sum(axis=0)
    carried = motion.push + 2j * rate * motion.speed - rate**2 * r
    spun = (torque - mu * capsule.body_mass * (r.conjugate() * carried).imag) / motion.inertia
    return spun, mu * (capsule.body_mass * (carried + 1j * spun * r) + friction.sum(axis=0))


def _gyration(
    rate: Array, spun: Array, bent: QuasiStatic, across: float, upright: float
) -> Complex:
    """Gyroscopic moment P [N m] of a body that tilts while it turns, its inertias being `across`
    the vertical and `upright` [kg m^2] (module docstring)."""
    g, g1, g2 = bent.gradient, bent.gradient_rate, bent.gradient_second
    tilted = across * (g2 + 2j * rate * g1 + (1j * spun - rate**2) * g)
    return tilted + upright * (rate**2 * g - 1j * spun * g - 1j * rate * g1)


def _growth(capsule: Capsule, motion: PlaneMotion, lost: Array) -> Array:
    """Bound on e' [kg^(1/2) m/s^2], shape (n,), of normal forces that lack `lost` [N], (3, n)."""
    towards = motion.directions
    force = (lost * towards).sum(axis=0)
    torque = (lost * (motion.arms.conjugate() * towards).imag).sum(axis=0)
    size = np.sqrt(np.abs(force) ** 2 / motion.mass + torque**2 / motion.inertia)
    sticking = np.where(towards == 0.0, np.abs(lost), 0.0)
    slides = np.where(motion.resting, 0.0, capsule.friction * size)
    return slides + _growth_at_most(capsule, motion, sticking)


def _growth_at_most(capsule: Capsule, motion: PlaneMotion, lost: Array) -> Array:
    """The same of normal forces that lack `lost` [N] or less, shape (3, n), in any way."""
    reach = np.sqrt(1.0 / motion.mass + np.abs(motion.arms) ** 2 / motion.inertia)
    size = capsule.friction * (lost * reach).sum(axis=0)
    return np.where(motion.resting, 0.0, size)


def _coupled_loads(
    capsule: Capsule, motion: PlaneMotion, normal: NormalContact, step: float
) -> Array:
    """Changes of the normal forces [N], shape (3, n), by kappa f times the slip acceleration.

    Contacts take up what is steady, or grows steadily; a jump perturbs N for a few contact time
    constants; and never by more than the load there is.
    """
    quick = np.gradient(np.abs(motion.slips), motion.times, axis=1)
    changed = np.abs(np.gradient(quick, motion.times, axis=1))
    changed[:, 0] += 2.0 * np.abs(quick[:, 0]) / (motion.times[1] - motion.times[0])  # from rest
    decay = step / (normal.damping_ratio * normal.frequency_step)
    lasting = soft_contact.QUASI_STATIC_FACTOR * decay
    altered = normal.coupling * capsule.friction * changed * lasting
    return np.asarray(np.minimum(altered, capsule.weight))


def _grown(capsule: Capsule, motion: PlaneMotion, growth: Array, count: int) -> Bounds:
    """Bounds from e' <= `growth` [kg^(1/2) m/s^2], shape (n,), where the error resets at rest; of
    `count` equal motions, each from rest."""
    times = motion.times
    spent = 0.5 * (growth[1:] + growth[:-1]) * np.diff(times)
    grown = np.append(0.0, np.cumsum(spent))
    energy = grown - np.maximum.accumulate(np.where(motion.resting, grown, 0.0))  # since rest
    turn, drift = energy / np.sqrt(motion.inertia), energy / math.sqrt(motion.mass)
    arm = capsule.mass_ratio * np.abs(motion.place)  # of C about the centre
    turned = float(np.trapezoid(turn, times)) * count
    way = float(np.trapezoid(motion.ground, times)) * count
    gone = float(np.trapezoid(drift, times)) * count + turned * (float(arm.max()) + way)
    speed = float((drift + arm * turn).max()) + turned * float(motion.ground.max())
    return _named(gone, speed, turned, float(turn.max()))


def _stiction_drift(
    problem: CapsuleProblem, motion: PlaneMotion, contact: SoftContact, count: int
) -> Bounds:
    """A support that sticks drifts at the slip compliance times f W or less."""
    capsule = problem.setup.capsule
    speed = contact.slip_compliance * capsule.friction * capsule.weight
    arm, lasting = shortest_arm(problem), float(motion.times[-1]) * count
    return _named(speed * lasting, speed, speed * lasting / arm, speed / arm)


def _slider_armature(
    problem: CapsuleProblem, motion: PlaneMotion, contact: SoftContact, count: int
) -> Bounds:
    """The slider's way in the body lacks m/A of its way in space, and the rounding of what
    drives it; the body's by no more than that."""
    speeds = np.abs(motion.speed) + motion.ground + np.abs(motion.rate * motion.place)
    mass, arm = problem.setup.capsule.slider_mass, shortest_arm(problem)
    once, speed = slider_in_the_plane(mass, contact.armature, motion.times, speeds)
    way = once * count
    loads = dict.fromkeys(NORMAL_FORCES, steepest_load(problem.setup.capsule) * way)
    return {**_named(way, speed, way / arm, speed / arm), **loads}


def _named(way: float, speed: float, turned: float, rate: float) -> Mapping[str, float]:
    return {
        **dict.fromkeys(("x", "y"), way),
        **dict.fromkeys(("velocity_x", "velocity_y"), speed),
        **dict.fromkeys(("heading", "body_angle"), turned),
        "heading_rate": rate,
    }
