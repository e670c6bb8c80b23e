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
    STICKING_SLIP,
    BodyError,
    ObservableErrors,
    SampledMotion,
    by_observable,
    sample_motion,
)
from plumbob.analytic.errors.contact_models.soft_contact import (
    DEPTH_ROUNDINGS,
    NormalContact,
    SoftContact,
)
from plumbob.analytic.errors.sliding_motion.plane_steps import trajectory
from plumbob.analytic.errors.sliding_motion.sliding_errors import MOST_PLANE_STEPS
from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import (
    UNIT_POSITIONS,
    Capsule,
    load_fractions,
    normal_forces,
)
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.three_points.equations import ComplexForces
from plumbob.analytic.systems.three_points.reference import PlaneReference

LAST_STEPS = 2.5  # steps for which a body drifts on after its stop, with Euler and with RK4
DRIVE_ROUNDINGS = 16  # roundings of the force that drives the slider's joint


@dataclass(frozen=True)
class QuasiStatic:
    """Deflections under static loads along a motion, and their derivatives."""

    depths: Array  # [m] heights of the supports, negative, shape (3, n)
    height: Array  # z [m], height of C, shape (n,)
    height_second: Array  # z'' [m/s^2]
    gradient: ComplexForces  # g, gradient of the body's plane
    gradient_rate: ComplexForces  # g' [1/s]
    gradient_second: ComplexForces  # g'' [1/s^2]


def model_error(
    problem: CapsuleProblem, duration: float, contact: SoftContact
) -> ObservableErrors:
    """Returns the bounds of soft contacts over `duration` [s]: {observable: {reason: bound}}."""
    motion = sample_motion(problem, duration)
    step = contact.step
    resting = _is_resting(problem, motion, duration, contact)
    # [m/s^2] error of the acceleration, in any direction, at which the solver stops
    residual = math.sqrt(2.0 * contact.solver_tolerance)
    growth = np.full((2, 1), residual * math.sqrt(motion.mass))
    solver_error = _accumulated_error(motion, resting, growth)
    # A sticking body keeps its error of the velocity until the next step.
    speed = solver_error.speed + residual * step
    place = solver_error.place + residual * step * duration
    solver_error = replace(solver_error, place=place, speed=speed)
    mechanisms: dict[str, tuple[BodyError, Any]] = {
        "drift of stiction": (_stiction_drift(problem, motion, contact), ()),
        "armature": (_armature_error(motion, contact), ()),
        "solver": (solver_error, np.full(3, residual * motion.mass)),
    }
    if contact.normal is not None:
        mechanisms |= _deflection_errors(motion, resting, contact, contact.normal)
    bounds = {}
    for reason, (error, loads) in mechanisms.items():
        bounds[reason] = motion.bounds(error, step, loads)
    return by_observable(bounds)


def _is_resting(
    problem: CapsuleProblem, motion: SampledMotion, duration: float, contact: SoftContact
) -> Any:
    """Returns for each time whether no support slips, shape (n,).

    If the motion has no closed form, two more conditions hold: the slider rests, because a residual
    rotation continues until friction has stopped it; and the motion in steps rests too. If there
    are too many steps, the second is not tested.
    """
    exact_rests = ~motion.slips.any(axis=0)
    if motion.formula:
        return exact_rests
    exact_rests &= motion.speed == 0.0
    steps = round(duration / contact.step)
    if steps > MOST_PLANE_STEPS:
        return exact_rests
    start = cast(PlaneReference, problem.reference).start
    path = problem.motion.path
    rows = trajectory(motion.capsule, path, start, contact.integrator, contact.step, steps)
    scales = [1.0, 1.0, np.abs(motion.supports).max()]
    stepped_speeds = np.abs(rows[:, 3:] * scales).sum(axis=1)
    stepped_moves = stepped_speeds > STICKING_SLIP * stepped_speeds.max()
    nearest_steps = np.rint(motion.times / contact.step).astype(int)
    return exact_rests & ~stepped_moves[np.minimum(nearest_steps, steps)]


def _stiction_drift(
    problem: CapsuleProblem, motion: SampledMotion, contact: SoftContact
) -> BodyError:
    """Returns the error by the drift of regularised stiction.

    A support that sticks drifts at the slip compliance times f W or less. A coasting body that has
    come to rest, without any push, keeps this velocity for a few steps only.
    """
    speed = contact.slip_compliance * motion.capsule.friction * motion.capsule.weight
    duration = motion.count * float(motion.times[-1])
    if problem.motion.kind == "coasting":
        duration = LAST_STEPS * contact.step
    arm = float(np.abs(motion.supports).min())
    return BodyError(
        place=speed * duration,
        speed=2.0 * speed,
        angle=speed * duration / arm,
        rate=speed / arm,
    )


def _armature_error(motion: SampledMotion, contact: SoftContact) -> BodyError:
    """Returns the error by the armature A of the slider's joint.

    The slider's path in the body is in error by m/A of its path in space, and by the rounding of
    the drive. On a line the reaction moves the body by the mass ratio times that error. In the
    plane the error of the body is at most the slider's.
    """
    if not motion.speed.any():
        return BodyError()
    capsule = motion.capsule
    rounding = DRIVE_ROUNDINGS * ROUNDOFF
    mass_over_armature = capsule.slider_mass / contact.armature
    relative_error = mass_over_armature + rounding
    speeds = np.abs(motion.speed) + np.abs(motion.velocity) + np.abs(motion.rate * motion.place)
    fastest = float(speeds.max())
    path = motion.count * float(np.trapezoid(speeds, motion.times)) + fastest * contact.step
    place = relative_error * path
    speed = relative_error * fastest
    largest_push = float(np.abs(motion.push).max()) + capsule.friction * capsule.gravity
    drive = mass_over_armature * largest_push + 2.0 * rounding * fastest / contact.step
    if motion.formula:
        mu = capsule.mass_ratio
        body_error = BodyError(place=mu * place, speed=mu * speed)
    else:
        arm = float(np.abs(motion.supports).min())
        body_error = BodyError(place, speed, place / arm, speed / arm)
    return replace(body_error, slider_place=place, slider_rate=speed, drive=drive)


def _deflection_errors(
    motion: SampledMotion, resting: Any, contact: SoftContact, normal: NormalContact
) -> dict[str, tuple[BodyError, Any]]:
    """Returns the errors of the body and of its loads [N] from deflecting contacts, by reason."""
    missing = missing_loads(motion, normal)
    loads = soft_contact.OVERSHOOT_FACTOR * np.abs(missing).max(axis=1)
    growth = soft_contact.QUASI_STATIC_FACTOR * _error_growth(motion, missing)
    errors: dict[str, tuple[BodyError, Any]] = {
        "contact deflection": (_accumulated_error(motion, resting, growth), loads),
        "tangential–normal coupling": _coupling_error(motion, contact, normal),
    }
    if motion.formula:
        errors["height of the centre of mass"] = _height_error(motion, contact, normal)
    return errors


def _height_error(
    motion: SampledMotion, contact: SoftContact, normal: NormalContact
) -> tuple[BodyError, Array]:
    """Returns the errors of the body and of its loads [N] from a centre of mass above the contacts.

    The source leaves this height out. Friction on a line has a moment about the centre of mass that
    shifts load along the line, and the centre of mass moves as the body tilts.
    """
    capsule = motion.capsule
    deflections = _quasi_static(motion, normal.compliance)
    depth = -float(deflections.depths.min())
    height = depth + normal.height  # height of C above the supports
    _, gradients = _load_fractions(motion.capsule)
    force = capsule.friction * capsule.weight
    direction = np.exp(1j * motion.line)
    # Load shift per height: friction sets in at once, and overshoot doubles its effect.
    load_shift = 2.0 * force * (gradients.conjugate() * direction).real
    tilt = abs(height * normal.compliance * (gradients * load_shift).sum())
    tilt += float(np.abs(deflections.gradient - deflections.gradient[0]).max())
    place = height * tilt
    sideways_speed = normal.height * tilt * contact.contact_rate
    angle = _angle_by_sideways_slip(motion, normal.height, sideways_speed)
    angle += depth * tilt / float(np.abs(motion.supports).min())
    loads = normal.height * np.abs(load_shift)
    return BodyError(place, place * contact.contact_rate, angle), loads


def _angle_by_sideways_slip(
    motion: SampledMotion, height: float, sideways_speed: float
) -> float:
    """Returns the angle [rad] by which friction turns a body whose supports slip sideways.

    The supports are `height` [m] below C. They have a `sideways_speed` [m/s] while the body tilts.
    This turns the direction of the slip by that speed over b t, with b the acceleration of C, and
    friction follows the slip (THEORY.md, section 9).
    """
    capsule = motion.capsule
    speeds = np.abs(motion.velocity)
    largest_speed = speeds.max() or math.inf
    time_to_largest_speed = motion.times[speeds.argmax()]  # ratio of the largest speed to b
    sliding_time = np.trapezoid(speeds > 0.0, motion.times)
    turn_of_slip = sideways_speed * float(time_to_largest_speed * sliding_time) / largest_speed
    force = capsule.friction * capsule.weight
    return float(force * height / capsule.inertia * turn_of_slip)


def missing_loads(motion: SampledMotion, normal: NormalContact) -> Array:
    """Returns the loads dN_i [N] that static loads lack under a body that tilts, shape (3, n).

    The equations are in the module docstring.
    """
    capsule = motion.capsule
    deflections = _quasi_static(motion, normal.compliance)
    lift, slider_height = _slider_lift(motion, deflections)
    friction = motion.loads * motion.traction
    total_friction = friction.sum(axis=0)
    spin, slider_force = _horizontal_reaction(motion, friction)
    force = capsule.body_mass * deflections.height_second + capsule.slider_mass * lift
    moment = capsule.slider_mass * lift * motion.place
    moment += _gyroscopic_moment(
        motion.rate, spin, deflections, normal.tilt_inertia, capsule.inertia
    )
    friction_moment = 0.5 * (deflections.depths * friction).sum(axis=0)
    moment += (
        -slider_height * slider_force - deflections.height * total_friction + friction_moment
    )
    central, gradients = _load_fractions(capsule)
    return np.outer(central, force) + (gradients.conjugate()[:, None] * moment).real


def _load_fractions(capsule: Capsule) -> tuple[Array, ComplexForces]:
    """Returns the fraction of a load at C on each support, and the gradients of the fractions.

    The gradients are complex numbers [1/m]; both results have the shape (3,). The fractions are
    linear in the place of the load. UNIT_POSITIONS are C and the places 1 m ahead and aside: the
    gradients are differences between them.
    """
    central, ahead, aside = load_fractions(capsule, UNIT_POSITIONS)
    return central, ahead - central + 1j * (aside - central)


def _quasi_static(motion: SampledMotion, compliance: float) -> QuasiStatic:
    """Returns the deflections of contacts of a `compliance` [m/N] under static loads."""
    central_depths, depths_x, depths_y = -compliance * normal_forces(
        motion.capsule, UNIT_POSITIONS
    )
    slopes = np.array([depths_x - central_depths, depths_y - central_depths]).T
    central, gradients = _load_fractions(motion.capsule)
    place, speed, push = (
        np.array([vector.real, vector.imag])
        for vector in (motion.place, motion.speed, motion.push)
    )
    depths = central_depths[:, None] + slopes @ place
    return QuasiStatic(
        depths=depths,
        height=central @ depths,
        height_second=central @ slopes @ push,
        gradient=gradients @ depths,
        gradient_rate=gradients @ slopes @ speed,
        gradient_second=gradients @ slopes @ push,
    )


def _slider_lift(motion: SampledMotion, deflections: QuasiStatic) -> tuple[Array, Array]:
    """Returns the slider's vertical acceleration q'' [m/s^2], and its height over C, q - z = g.r
    [m], each of shape (n,)."""
    r = motion.place
    g = deflections.gradient.conjugate()
    g_rate = deflections.gradient_rate.conjugate()
    g_second = deflections.gradient_second.conjugate()
    relative = g_second * r + 2.0 * g_rate * motion.speed + g * motion.push
    return deflections.height_second + relative.real, (g * r).real


def _horizontal_reaction(
    motion: SampledMotion, friction: ComplexForces
) -> tuple[Array, ComplexForces]:
    """Returns the body's angular acceleration [rad/s^2] and the horizontal force on the slider [N].

    The force is m b in the module docstring. `friction` holds the forces F_i [N], shape (3, n).
    """
    r = motion.place
    rate = motion.rate
    capsule = motion.capsule
    mu = motion.capsule.mass_ratio
    friction_torque = (motion.arms.conjugate() * friction).imag.sum(axis=0)
    relative = motion.push + 2j * rate * motion.speed - rate**2 * r
    slider_torque = mu * capsule.body_mass * (r.conjugate() * relative).imag
    spin = (friction_torque - slider_torque) / motion.inertia
    inertial_force = capsule.body_mass * (relative + 1j * spin * r)
    return spin, mu * (inertial_force + friction.sum(axis=0))


def _gyroscopic_moment(
    rate: Array, spin: Array, deflections: QuasiStatic, across: float, upright: float
) -> ComplexForces:
    """Returns the gyroscopic moment P [N m] of a body that tilts while it turns (module docstring).

    The body's moments of inertia are `across`, about a horizontal axis, and `upright`, about the
    vertical axis [kg m^2]. `rate` and `spin` are its angular velocity and acceleration.
    """
    g = deflections.gradient
    g_rate = deflections.gradient_rate
    g_second = deflections.gradient_second
    tilting = across * (g_second + 2j * rate * g_rate + (1j * spin - rate**2) * g)
    return tilting + upright * (rate**2 * g - 1j * spin * g - 1j * rate * g_rate)


def _error_growth(motion: SampledMotion, missing: Array) -> Array:
    """Returns the two parts of e' (module docstring) [kg^(1/2) m/s^2], shape (2, n).

    `missing` [N], shape (3, n), is the error of the normal forces. On a line without rotation the
    parts keep their signs. If the body also turns, the first part is an absolute value. If the
    motion has no closed form, the result is a bound on the sum, shape (n,).
    """
    directions = motion.directions
    force = (missing * directions).sum(axis=0) / math.sqrt(motion.mass)
    torque = (missing * (motion.arms.conjugate() * directions).imag).sum(axis=0)
    parts = motion.capsule.friction * np.array([force, torque / np.sqrt(motion.inertia)])
    if motion.formula and motion.rate.any():
        return np.array([np.abs(parts[0]), parts[1]])
    if motion.formula:
        return parts
    reach = np.sqrt(1.0 / motion.mass + np.abs(motion.arms) ** 2 / motion.inertia)
    sticking = (np.where(directions, 0.0, np.abs(missing)) * reach).sum(axis=0)
    return np.asarray(np.hypot(*np.abs(parts)) + motion.capsule.friction * sticking)


def _coupling_error(
    motion: SampledMotion, contact: SoftContact, normal: NormalContact
) -> tuple[BodyError, Array]:
    """Returns the errors of the body and of its loads [N] from tangential–normal coupling.

    A slip acceleration a [m/s^2] changes the normal force by kappa f a [N] until the deflection of
    the contacts has compensated that change. At a start and at a stop, a is the slip over a step.
    The loads include the rounding of the contact depths.
    """
    capsule = motion.capsule
    reach = float(np.abs(motion.supports).max())
    load_per_acceleration = normal.coupling * capsule.friction
    slip_speeds = np.abs(motion.slips)
    accelerations = np.abs(np.gradient(slip_speeds, motion.times, axis=1))
    smooth_load = load_per_acceleration * float(accelerations.max())
    start_load = load_per_acceleration * float(slip_speeds[:, 0].max()) / contact.step
    stop_load = load_per_acceleration * float(slip_speeds.max()) / contact.step
    moving_load = smooth_load + start_load
    place_per_load = soft_contact.QUASI_STATIC_FACTOR * capsule.friction * normal.compliance
    lever = normal.tilt_inertia * float(np.abs(_load_fractions(capsule)[1]).sum())
    angle = place_per_load * moving_load * (lever + motion.mass * reach) / capsule.inertia
    loads = soft_contact.OVERSHOOT_FACTOR * smooth_load + start_load
    loads += DEPTH_ROUNDINGS * ROUNDOFF * reach / normal.compliance
    error = BodyError(
        place=place_per_load * (moving_load + stop_load),
        speed=2.0 * place_per_load * moving_load * contact.contact_rate,
        angle=angle,
        rate=angle * contact.contact_rate,
    )
    return error, np.full(3, loads)


def _accumulated_error(motion: SampledMotion, resting: Any, growth: Array) -> BodyError:
    """Returns the error of a body whose velocities have an error e that grows at the rates
    `growth`.

    `growth` [kg^(1/2) m/s^2] has the two parts of e' (module docstring): the shape (2, n), or one
    that broadcasts to it. Whenever the body is `resting`, shape (n,), e resets to zero.
    """
    times = motion.times
    growth = np.where(resting, 0.0, growth * np.ones((2, 1)))
    integral = cumulative_trapezoid(growth, times, initial=0)
    last_rest = np.maximum.accumulate(np.where(resting, np.arange(len(times)), 0))
    error_since_rest = integral - integral[:, last_rest]
    velocities = error_since_rest / np.sqrt([np.full(len(times), motion.mass), motion.inertia])
    distances = motion.count * np.abs(cumulative_trapezoid(velocities, times)).max(axis=1)
    place, angle = map(float, distances)
    speed, rate = map(float, np.abs(velocities).max(axis=1))
    return BodyError(place, speed, angle, rate)
