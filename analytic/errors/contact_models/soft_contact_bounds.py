"""Model errors of soft contacts on a motion of the capsule: bounds by reason.

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

the errors of the rates are e/I^(1/2) and e/(M + m)^(1/2), of angle and place their integrals. On a
line the d_i stay what they are, and what the two terms add up to, with their signs, is the error.
The friction of a support that sticks may differ in any direction. The error resets where no support
slips, of the exact motion and of that of the steps.
Derivations: THEORY.md, section 9.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from scipy.integrate import cumulative_trapezoid

from plumbob.analytic.errors.contact_models import soft_contact
from plumbob.analytic.errors.contact_models.model_error import (
    STILL,
    BodyError,
    ModelError,
    SampledMotion,
    by_observable,
    sampled,
)
from plumbob.analytic.errors.contact_models.soft_contact import (
    DEPTH_ROUNDINGS,
    NormalContact,
    SoftContact,
)
from plumbob.analytic.errors.sliding_motion.plane_steps import trajectory
from plumbob.analytic.errors.sliding_motion.sliding_errors import MOST_PLANE_STEPS
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import ROUNDOFF, Capsule, load_fractions, normal_forces
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.three_points.equations import Complex
from plumbob.analytic.systems.three_points.reference import PlaneReference

LAST_STEPS = 2.5  # steps at the drift's speed that a stop takes longer, of Euler and of RK4
DRIVE_ROUNDINGS = 16  # of what drives the slider's joint
CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


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
    """{observable: {reason: bound}} of a motion of the capsule over `duration` [s]."""
    motion = sampled(problem, duration)
    step = contact.step
    resting = _resting(problem, motion, duration, contact)
    # an acceleration [m/s^2], in any direction
    left = math.sqrt(2.0 * contact.solver_tolerance)
    unsolved = _grown(motion, resting, np.full((2, 1), left * math.sqrt(motion.mass)))
    speed = unsolved.speed + left * step  # while it sticks, until the next step
    way = unsolved.place + left * step * duration
    mechanisms: dict[str, tuple[BodyError, Any]] = {
        "drift of stiction": (_stiction_drift(problem, motion, contact), ()),
        "armature": (_armature(motion, contact), ()),
        "solver": (replace(unsolved, place=way, speed=speed), np.full(3, left * motion.mass)),
    }
    if contact.normal is not None:
        mechanisms |= _deflection(motion, resting, contact, contact.normal)
    return by_observable(
        {why: motion.bounds(error, step, loads) for why, (error, loads) in mechanisms.items()}
    )


def _resting(
    problem: CapsuleProblem, motion: SampledMotion, duration: float, contact: SoftContact
) -> Any:
    """Whether no support slips, shape (n,), of the exact motion and in the plane of that of the
    steps, unless they are too many to be taken: the residual of a turn continues until friction
    has stopped that too."""
    still = ~motion.slips.any(axis=0)
    if motion.formula:
        return still
    still &= motion.speed == 0.0
    if (steps := round(duration / contact.step)) > MOST_PLANE_STEPS:
        return still
    begun = cast(PlaneReference, problem.reference).start
    driven = (motion.capsule, problem.motion.path, begun)
    rows = trajectory(*driven, contact.integrator, contact.step, steps)
    moved = np.abs(rows[:, 3:] * [1.0, 1.0, np.abs(motion.supports).max()]).sum(axis=1)
    moving = moved > STILL * moved.max()
    return still & ~moving[np.minimum(np.rint(motion.times / contact.step).astype(int), steps)]


def _stiction_drift(
    problem: CapsuleProblem, motion: SampledMotion, contact: SoftContact
) -> BodyError:
    """A support that sticks drifts at the slip compliance times f W or less; one that nothing
    pushes, of a body that has come to rest, keeps that velocity for some steps."""
    speed = contact.slip_compliance * motion.capsule.friction * motion.capsule.weight
    lasting = motion.count * float(motion.times[-1])
    if problem.motion.kind == "coasting":
        lasting = LAST_STEPS * contact.step
    arm = float(np.abs(motion.supports).min())
    return BodyError(speed * lasting, 2.0 * speed, speed * lasting / arm, speed / arm)


def _armature(motion: SampledMotion, contact: SoftContact) -> BodyError:
    """The slider's way in the body lacks m/A of its way in space, and the rounding of what drives
    it; the body's by the reaction to that, and in the plane by no more than that."""
    if not motion.speed.any():
        return BodyError()
    capsule = motion.capsule
    rounded = DRIVE_ROUNDINGS * ROUNDOFF
    part = capsule.slider_mass / contact.armature
    speeds = np.abs(motion.speed) + np.abs(motion.velocity) + np.abs(motion.rate * motion.place)
    fastest = float(speeds.max())
    gone = motion.count * float(np.trapezoid(speeds, motion.times)) + fastest * contact.step
    way = (part + rounded) * gone
    speed = (part + rounded) * fastest
    pushed = float(np.abs(motion.push).max()) + capsule.friction * capsule.gravity
    drive = part * pushed + 2.0 * rounded * fastest / contact.step
    if motion.formula:
        mu = capsule.mass_ratio
        return BodyError(mu * way, mu * speed, slid=way, slider_rate=speed, drive=drive)
    arm = float(np.abs(motion.supports).min())
    return BodyError(way, speed, way / arm, speed / arm, way, speed, drive)


def _deflection(
    motion: SampledMotion, resting: Any, contact: SoftContact, normal: NormalContact
) -> dict[str, tuple[BodyError, Any]]:
    """Errors of the body and of its loads [N] by contacts that deflect, by reason."""
    lost = missing_loads(motion, normal)
    swung = soft_contact.OVERSHOOT_FACTOR * np.abs(lost).max(axis=1)
    deflected = soft_contact.QUASI_STATIC_FACTOR * _growth(motion, lost)
    parts: dict[str, tuple[BodyError, Any]] = {
        "contact deflection": (_grown(motion, resting, deflected), swung),
        "tangential–normal coupling": _coupling(motion, contact, normal),
    }
    if motion.formula:
        parts["height of the centre of mass"] = _raised(motion, contact, normal)
    return parts


def _raised(
    motion: SampledMotion, contact: SoftContact, normal: NormalContact
) -> tuple[BodyError, Array]:
    """Of a centre of mass above the contacts, which the source leaves out: friction on a line has a
    moment about it that shifts load along the line, and it moves as the body tilts."""
    capsule = motion.capsule
    bent = _quasi_static(motion, normal.compliance)
    depth = -float(bent.depths.min())
    (_, tilting) = _fractions(motion.capsule)
    force = capsule.friction * capsule.weight
    along = np.exp(1j * motion.line)
    # by 1 m: friction sets in at once
    shifted = 2.0 * force * (tilting.conjugate() * along).real
    tilt = abs((depth + normal.height) * normal.compliance * (tilting * shifted).sum())
    tilt += float(np.abs(bent.gradient - bent.gradient[0]).max())
    way = (depth + normal.height) * tilt
    speeds = np.abs(motion.velocity)
    # Supports far below C slip aside while the body tips, and friction follows the slip.
    lasting = float(motion.times[speeds.argmax()] * np.trapezoid(speeds > 0.0, motion.times))
    aside = normal.height * tilt * contact.contact_rate * lasting / (speeds.max() or math.inf)
    turn = force * normal.height / capsule.inertia * aside
    turn += depth * tilt / float(np.abs(motion.supports).min())
    return BodyError(way, way * contact.contact_rate, turn), normal.height * np.abs(shifted)


def missing_loads(motion: SampledMotion, normal: NormalContact) -> Array:
    """dN_i [N], shape (3, n), of contacts under a body that tilts (module docstring)."""
    capsule = motion.capsule
    bent = _quasi_static(motion, normal.compliance)
    lifted, over = _slider_height(motion, bent)
    friction = motion.loads * motion.traction
    dragged = friction.sum(axis=0)
    spun, drawn = _horizontal(motion, friction)
    total = capsule.body_mass * bent.height_second + capsule.slider_mass * lifted
    moment = capsule.slider_mass * lifted * motion.place
    moment += _gyration(motion.rate, spun, bent, normal.tilt_inertia, capsule.inertia)
    moment += -over * drawn - bent.height * dragged + 0.5 * (bent.depths * friction).sum(axis=0)
    central, tilting = _fractions(capsule)
    return np.outer(central, total) + (tilting.conjugate()[:, None] * moment).real


def _fractions(capsule: Capsule) -> tuple[Array, Complex]:
    """Fractions of the load on each support with its centre at C, and their slopes as complex
    numbers [1/m], shape (3,) each."""
    central, ahead, aside = load_fractions(capsule, CORNERS)
    return central, ahead - central + 1j * (aside - central)


def _quasi_static(motion: SampledMotion, compliance: float) -> QuasiStatic:
    """Deflections of contacts of a `compliance` [m/N] under the loads of statics."""
    here, ahead, aside = -compliance * normal_forces(motion.capsule, CORNERS)
    slopes = np.array([ahead - here, aside - here]).T
    (central, tilting) = _fractions(motion.capsule)
    place, speed, push = (
        np.array([vector.real, vector.imag])
        for vector in (motion.place, motion.speed, motion.push)
    )
    depths = here[:, None] + slopes @ place
    return QuasiStatic(
        depths=depths,
        height=central @ depths,
        height_second=central @ slopes @ push,
        gradient=tilting @ depths,
        gradient_rate=tilting @ slopes @ speed,
        gradient_second=tilting @ slopes @ push,
    )


def _slider_height(motion: SampledMotion, bent: QuasiStatic) -> tuple[Array, Array]:
    """q'' [m/s^2] of the slider, and its height over C, q - z = g.r [m], each of shape (n,)."""
    r = motion.place
    v = motion.speed
    w = motion.push
    curved = bent.gradient_second.conjugate() * r + 2.0 * bent.gradient_rate.conjugate() * v
    lifted = bent.height_second + (curved + bent.gradient.conjugate() * w).real
    return lifted, (bent.gradient.conjugate() * r).real


def _horizontal(motion: SampledMotion, friction: Complex) -> tuple[Array, Complex]:
    """Angular acceleration of the body [rad/s^2] and the horizontal force on the slider [N] under
    the `friction` F_i [N], shape (3, n): m b in the module docstring."""
    r = motion.place
    rate = motion.rate
    capsule = motion.capsule
    mu = motion.capsule.mass_ratio
    torque = (motion.arms.conjugate() * friction).imag.sum(axis=0)
    carried = motion.push + 2j * rate * motion.speed - rate**2 * r
    spun = (torque - mu * capsule.body_mass * (r.conjugate() * carried).imag) / motion.inertia
    return spun, mu * (capsule.body_mass * (carried + 1j * spun * r) + friction.sum(axis=0))


def _gyration(
    rate: Array, spun: Array, bent: QuasiStatic, across: float, upright: float
) -> Complex:
    """Gyroscopic moment P [N m] of a body that tilts while it turns, its inertias being `across`
    the vertical and `upright` [kg m^2] (module docstring)."""
    g = bent.gradient
    g1 = bent.gradient_rate
    g2 = bent.gradient_second
    tilted = across * (g2 + 2j * rate * g1 + (1j * spun - rate**2) * g)
    return tilted + upright * (rate**2 * g - 1j * spun * g - 1j * rate * g1)


def _growth(motion: SampledMotion, lost: Array) -> Array:
    """The two parts of e' [kg^(1/2) m/s^2], shape (2, n), of normal forces that lack `lost` [N],
    shape (3, n); on a line with their signs, elsewhere each a bound on all of it."""
    towards = motion.directions
    force = (lost * towards).sum(axis=0) / math.sqrt(motion.mass)
    torque = (lost * (motion.arms.conjugate() * towards).imag).sum(axis=0)
    parts = motion.capsule.friction * np.array([force, torque / np.sqrt(motion.inertia)])
    if motion.formula:
        return np.array([np.abs(parts[0]), parts[1]]) if motion.rate.any() else parts
    reach = np.sqrt(1.0 / motion.mass + np.abs(motion.arms) ** 2 / motion.inertia)
    held = (np.where(towards, 0.0, np.abs(lost)) * reach).sum(axis=0)
    return np.asarray(np.hypot(*np.abs(parts)) + motion.capsule.friction * held)


def _coupling(
    motion: SampledMotion, contact: SoftContact, normal: NormalContact
) -> tuple[BodyError, Array]:
    """A normal force that a slip acceleration a [m/s^2] changes by kappa f a [N], until the
    contacts' deflection has taken it up; and its error from the rounding of their depth."""
    capsule = motion.capsule
    reach = float(np.abs(motion.supports).max())
    altered = normal.coupling * capsule.friction
    sizes = np.abs(motion.slips)
    quick = altered * float(np.abs(np.gradient(sizes, motion.times, axis=1)).max())
    sudden, growing = (altered * float(x.max()) / contact.step for x in (sizes[:, 0], sizes))
    factor = soft_contact.QUASI_STATIC_FACTOR * capsule.friction * normal.compliance
    lever = normal.tilt_inertia * float(np.abs(_fractions(capsule)[1]).sum())
    speed = 2.0 * factor * (quick + sudden) * contact.contact_rate
    turn = factor * (quick + sudden) * (lever + motion.mass * reach) / capsule.inertia
    loads = soft_contact.OVERSHOOT_FACTOR * quick + sudden
    loads += DEPTH_ROUNDINGS * ROUNDOFF * reach / normal.compliance
    way = factor * (quick + sudden + growing)
    return BodyError(way, speed, turn, turn * contact.contact_rate), np.full(3, loads)


def _grown(motion: SampledMotion, resting: Any, growth: Array) -> BodyError:
    """Error from the parts of e', `growth` [kg^(1/2) m/s^2], shape (2, n), that resets where the
    body is `resting`, shape (n,)."""
    times = motion.times
    growth = np.where(resting, 0.0, growth * np.ones((2, 1)))
    grown = cumulative_trapezoid(growth, times, initial=0)
    since = np.maximum.accumulate(np.where(resting, np.arange(len(times)), 0))
    energy = grown - grown[:, since]
    rates = energy / np.sqrt([np.full(len(times), motion.mass), motion.inertia])
    ways = motion.count * np.abs(cumulative_trapezoid(rates, times)).max(axis=1)
    fastest = np.abs(rates).max(axis=1)
    return BodyError(float(ways[0]), float(fastest[0]), float(ways[1]), float(fastest[1]))
