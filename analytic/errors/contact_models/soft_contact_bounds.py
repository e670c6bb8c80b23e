"""Model errors of soft contacts on a motion of the capsule: bounds by reason.

Deflection dynamics. The deflections c N_i are affine in the slider's position r. They put C at a
height z and give the body's plane a gradient g, so that the slider Q has the height q = z + g.r.
F_i are the friction forces, a and b the horizontal accelerations of C and Q. Plane vectors are
complex numbers in body axes. The static loads lack

    sum dN_i     = M z'' + m q''
    sum dN_i A_i = m q'' r + P - (q - z) m b - z sum F_i + sum z_i F_i/2,
    P = I_a (g'' + 2i w g' + (i w' - w^2) g) + J (w^2 g - i w' g - i w g')

where w is the body's rate, and I_a its inertia about a horizontal axis. The terms are the vertical
inertia, gyroscopic moments, and moments of horizontal forces at their heights. A contact acts
halfway down its depth.

Contraction. If the N_i differ from the static loads by dN_i, friction differs by f dN_i at each
support. A property of dry friction bounds the effect: at given normal forces, the velocities of two
motions of a body never diverge. The distance is the kinetic energy of the difference of the
velocities, on which friction does no positive work. With e the root of twice that energy, and d_i
the directions of slip,

    e' <= ((sum f dN_i d_i)^2/(M + m) + (sum f dN_i rho_i x d_i)^2/I)^(1/2),    rho_i = CA_i - mu r,

The errors of the rates are e/I^(1/2) and e/(M + m)^(1/2). The errors of angle and position are
their integrals. On a line the d_i are constant, and the integrals of the two terms, with their
signs, are the error itself. The friction of a support that sticks may differ in any direction. The
error resets when no support slips, neither in the exact motion nor in the stepped one.
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

LAST_STEPS = 2.5  # steps for which a body drifts on after its stop, with Euler and with RK4
DRIVE_ROUNDINGS = 16  # roundings of the force that drives the slider's joint
# Positions of the slider [m] at C, and 1 m along x and y, by which affine loads are known.
CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


@dataclass(frozen=True)
class QuasiStatic:
    """Deflections under static loads along a motion, and their derivatives."""

    depths: Array  # [m] heights of the supports, negative, shape (3, n)
    height: Array  # z [m], height of C, shape (n,)
    height_second: Array  # z'' [m/s^2]
    gradient: Complex  # g, gradient of the body's plane
    gradient_rate: Complex  # g' [1/s]
    gradient_second: Complex  # g'' [1/s^2]


def model_error(problem: CapsuleProblem, duration: float, contact: SoftContact) -> ModelError:
    """Returns the bounds of soft contacts over `duration` [s]: {observable: {reason: bound}}."""
    motion = sampled(problem, duration)
    step = contact.step
    resting = _resting(problem, motion, duration, contact)
    # The solver leaves an error of the acceleration [m/s^2], in any direction.
    left = math.sqrt(2.0 * contact.solver_tolerance)
    unsolved = _grown(motion, resting, np.full((2, 1), left * math.sqrt(motion.mass)))
    speed = unsolved.speed + left * step  # a sticking body keeps an error until the next step
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
    """Returns the times at which no support slips, as truth values of shape (n,).

    If the motion has no closed form, the stepped motion must rest as well, and so must the slider:
    a residual rotation continues until friction has stopped it. If there are too many steps, the
    stepped motion is not tested.
    """
    still = ~motion.slips.any(axis=0)
    if motion.formula:
        return still
    still &= motion.speed == 0.0
    if (steps := round(duration / contact.step)) > MOST_PLANE_STEPS:
        return still
    begun = cast(PlaneReference, problem.reference).begun
    driven = (motion.capsule, problem.motion.path, begun)
    rows = trajectory(*driven, contact.integrator, contact.step, steps)
    moved = np.abs(rows[:, 3:] * [1.0, 1.0, np.abs(motion.supports).max()]).sum(axis=1)
    moving = moved > STILL * moved.max()
    return still & ~moving[np.minimum(np.rint(motion.times / contact.step).astype(int), steps)]


def _stiction_drift(
    problem: CapsuleProblem, motion: SampledMotion, contact: SoftContact
) -> BodyError:
    """Returns the error by the drift of regularised stiction.

    A support that sticks drifts at the slip compliance times f W or less. A coasting body that has
    come to rest, without any push, keeps this velocity for a few steps only.
    """
    speed = contact.slip_compliance * motion.capsule.friction * motion.capsule.weight
    lasting = motion.count * float(motion.times[-1])
    if problem.motion.kind == "coasting":
        lasting = LAST_STEPS * contact.step
    arm = float(np.abs(motion.supports).min())
    return BodyError(speed * lasting, 2.0 * speed, speed * lasting / arm, speed / arm)


def _armature(motion: SampledMotion, contact: SoftContact) -> BodyError:
    """Returns the error by the armature A of the slider's joint.

    The slider's path in the body is in error by m/A of its path in space, and by the rounding of
    the drive. On a line the reaction moves the body by the mass ratio times that error. In the
    plane the error of the body is at most the slider's.
    """
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
    """Returns the errors of the body and of its loads [N] from deflecting contacts, by reason."""
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
    """Returns the errors of the body and of its loads [N] from a centre of mass above the contacts.

    The source leaves this height out. Friction on a line has a moment about the centre of mass that
    shifts load along the line, and the centre of mass moves as the body tilts.
    """
    capsule = motion.capsule
    bent = _quasi_static(motion, normal.compliance)
    depth = -float(bent.depths.min())
    (_, tilting) = _fractions(motion.capsule)
    force = capsule.friction * capsule.weight
    along = np.exp(1j * motion.line)
    # Friction sets in at once: the shift of the loads is a jump.
    shifted = 2.0 * force * (tilting.conjugate() * along).real
    tilt = abs((depth + normal.height) * normal.compliance * (tilting * shifted).sum())
    tilt += float(np.abs(bent.gradient - bent.gradient[0]).max())
    way = (depth + normal.height) * tilt
    speeds = np.abs(motion.velocity)
    # Supports far below C slip sideways while the body tilts, and friction follows the slip.
    lasting = float(motion.times[speeds.argmax()] * np.trapezoid(speeds > 0.0, motion.times))
    aside = normal.height * tilt * contact.contact_rate * lasting / (speeds.max() or math.inf)
    turn = force * normal.height / capsule.inertia * aside
    turn += depth * tilt / float(np.abs(motion.supports).min())
    return BodyError(way, way * contact.contact_rate, turn), normal.height * np.abs(shifted)


def missing_loads(motion: SampledMotion, normal: NormalContact) -> Array:
    """Returns the loads dN_i [N] that static loads lack under a body that tilts, shape (3, n).

    The equations are in the module docstring.
    """
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
    """Returns the fraction of a load at C on each support, and the fractions' gradients.

    The gradients are complex numbers [1/m]; both results have the shape (3,).
    """
    central, ahead, aside = load_fractions(capsule, CORNERS)
    return central, ahead - central + 1j * (aside - central)


def _quasi_static(motion: SampledMotion, compliance: float) -> QuasiStatic:
    """Returns the deflections of contacts of a `compliance` [m/N] under static loads."""
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
    """Returns the slider's vertical acceleration q'' [m/s^2], and its height over C, q - z = g.r
    [m], each of shape (n,)."""
    r = motion.place
    v = motion.speed
    w = motion.push
    curved = bent.gradient_second.conjugate() * r + 2.0 * bent.gradient_rate.conjugate() * v
    lifted = bent.height_second + (curved + bent.gradient.conjugate() * w).real
    return lifted, (bent.gradient.conjugate() * r).real


def _horizontal(motion: SampledMotion, friction: Complex) -> tuple[Array, Complex]:
    """Returns the body's angular acceleration [rad/s^2] and the horizontal force on the slider [N].

    The force is m b in the module docstring. `friction` holds the forces F_i [N], shape (3, n).
    """
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
    """Returns the gyroscopic moment P [N m] of a body that tilts while it turns (module docstring).

    The body's moments of inertia are `across`, about a horizontal axis, and `upright`, about the
    vertical axis [kg m^2]. `rate` and `spun` are its angular velocity and acceleration.
    """
    g = bent.gradient
    g1 = bent.gradient_rate
    g2 = bent.gradient_second
    tilted = across * (g2 + 2j * rate * g1 + (1j * spun - rate**2) * g)
    return tilted + upright * (rate**2 * g - 1j * spun * g - 1j * rate * g1)


def _growth(motion: SampledMotion, lost: Array) -> Array:
    """Returns the two parts of e' (module docstring) [kg^(1/2) m/s^2], shape (2, n).

    `lost` [N], shape (3, n), is the error of the normal forces. On a line without rotation the
    parts keep their signs. If the body also turns, the first part is an absolute value. If the
    motion has no closed form, the result is a bound on the sum, shape (n,).
    """
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
    """Returns the errors of the body and of its loads [N] from tangential–normal coupling.

    A slip acceleration a [m/s^2] changes the normal force by kappa f a [N], until the deflection of
    the contacts has compensated the change. The rounding of the contact depths is added to the
    loads.
    """
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
    """Returns the error of the body that grows at the rates `growth`, the two parts of e'.

    `growth` [kg^(1/2) m/s^2] has the shape (2, n), or a shape that broadcasts to it. Whenever the
    body is `resting`, shape (n,), the error of the velocities resets to zero.
    """
    times = motion.times
    growth = np.where(resting, 0.0, growth * np.ones((2, 1)))
    grown = cumulative_trapezoid(growth, times, initial=0)
    since = np.maximum.accumulate(np.where(resting, np.arange(len(times)), 0))
    energy = grown - grown[:, since]
    rates = energy / np.sqrt([np.full(len(times), motion.mass), motion.inertia])
    ways = motion.count * np.abs(cumulative_trapezoid(rates, times)).max(axis=1)
    fastest = np.abs(rates).max(axis=1)
    return BodyError(float(ways[0]), float(fastest[0]), float(ways[1]), float(fastest[1]))
