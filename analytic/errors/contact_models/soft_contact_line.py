"""Model errors of soft contacts on motions with a closed form: bounds, mechanism by mechanism.

A contact that deflects by c N lets the common centre of mass stand at z = -c sum N_i^2 / W, so the
error of the weight on the plane is (M + m) z'', of the velocity of a sliding body f z' and of its
place f (z - z0). The inertial loads of body and slider as the deflections change are missing from
the N_i, and friction acts at the depth of the deflection. While the body tilts by a, friction has
the moment f I_a a'' about C, so the body turns by f I_a a/J. Derivations: THEORY.md, section 9.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from plumbob.analytic.errors.contact_models import soft_contact
from plumbob.analytic.errors.contact_models.added_inertia import slider_on_a_line
from plumbob.analytic.errors.contact_models.model_error import (
    Bounds,
    ModelError,
    by_observable,
    with_drive,
)
from plumbob.analytic.errors.contact_models.soft_contact import (
    DEPTH_ROUNDINGS,
    NormalContact,
    SoftContact,
    load_fraction_slopes,
    shortest_arm,
)
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import NORMAL_FORCES, ROUNDOFF, load_fractions, normal_forces
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre

LAST_STEPS = 2.5  # steps at the drift's speed that a stop takes longer, of Euler and of RK4
POINTS = 4001  # of the motion that is looked at; its forces are piecewise smooth
PLACES = ("displacement", "x", "y")
VELOCITIES = ("velocity", "velocity_x", "velocity_y")


@dataclass(frozen=True)
class LineMotion:
    """A problem with a closed form, and the quantities that the mechanisms use."""

    problem: CapsuleProblem
    duration: float  # [s]

    @property
    def mass(self) -> float:
        """M + m [kg]."""
        capsule = self.problem.setup.capsule
        return capsule.body_mass + capsule.slider_mass

    @property
    def along(self) -> Array:
        """Unit vector of the line, body axes, shape (2,)."""
        line = self.problem.setup.direction
        return np.array([math.cos(line), math.sin(line)])

    @property
    def line(self) -> LineManoeuvre | None:
        """The manoeuvre of the closed form, the first of several; None where the motion has
        none."""
        motion = self.problem.motion
        return motion.single if motion.kind in ("line", "repeated-line") else None

    @property
    def coasting(self) -> bool:
        """Whether the slider is fixed in the body, which coasts to rest."""
        return bool(self.problem.motion.kind == "coasting")

    @property
    def count(self) -> int:
        """Number of equal motions."""
        return int(self.problem.motion.count)

    def loads(self) -> tuple[Array, Array, Array]:
        """Times of one manoeuvre [s], shape (n,), normal forces there [N], shape (3, n), and the
        way of the slider in the body [m], shape (n,)."""
        problem = self.problem
        times = np.linspace(0.0, min(self.duration, float(problem.motion.period)), POINTS)
        if self.coasting:
            still = normal_forces(problem.setup.capsule, np.array([problem.setup.slider]))
            return times, np.repeat(still.T, POINTS, axis=1), np.zeros(POINTS)
        observed = problem.reference.observe(times)
        return times, np.stack([observed[name] for name in NORMAL_FORCES]), observed["stroke"]


@dataclass(frozen=True)
class Deflection:
    """Largest vertical displacement and tilt of a body on quasi-static contacts during a motion."""

    lowered: float  # vertical displacement of the centre of mass from its start [m]
    speed: float  # and its rate [m/s]
    acceleration: float  # [m/s^2]
    tilt: float  # gradient of the body's plane against its start
    tilt_across: float  # the part of it across the line
    lean: float  # gradient of the body's plane
    start_lean: float  # at the start
    moment_loads: Array  # loads shifted by the moment of friction about C [N], shape (3,)
    inertial_loads: Array  # loads taken by body and slider moving up and down [N], shape (3,)
    stroke: float  # largest way of the slider in the body [m]


def model_error(problem: CapsuleProblem, duration: float, contact: SoftContact) -> ModelError:
    """{observable: {reason: bound}} of a motion with a closed form over `duration` [s]."""
    motion = LineMotion(problem, duration)
    bounds = {why: bound(motion, contact) for why, bound in MECHANISMS.items()}
    capsule, step = problem.setup.capsule, contact.step
    return by_observable({why: with_drive(terms, capsule, step) for why, terms in bounds.items()})


def stiction_drift(motion: LineMotion, contact: SoftContact) -> Bounds:
    """A body that sticks under a force F drifts at the slip compliance times F <= f W or less; one
    that coasts to rest keeps at most that velocity, for a step."""
    capsule = motion.problem.setup.capsule
    speed = contact.slip_compliance * capsule.friction * capsule.weight
    if motion.coasting:
        turned = motion.problem.motion.centre is not None
        return {} if turned else _drift_after_a_stop(contact, speed)
    way = speed * motion.duration
    return {
        **dict.fromkeys(("displacement", "sideways"), way),
        "velocity": speed,
        "friction_force": 2 * motion.mass * speed / contact.step,  # where the force is reversed
        "heading": way / shortest_arm(motion.problem),
    }


def _drift_after_a_stop(contact: SoftContact, speed: float) -> Bounds:
    way = LAST_STEPS * speed * contact.step
    return {**dict.fromkeys(("x", "y"), way), **dict.fromkeys(("velocity_x", "velocity_y"), speed)}


def slider_armature(motion: LineMotion, contact: SoftContact) -> Bounds:
    """A slider's joint of finite armature follows its control except for m/A of its other
    acceleration."""
    if motion.problem.setup.relative_velocity is None:
        return {}
    times = np.linspace(0.0, motion.duration, POINTS)
    return slider_on_a_line(
        motion.problem, times, contact.armature, contact.step, motion.line, motion.count
    )


def solver_accuracy(motion: LineMotion, contact: SoftContact) -> Bounds:
    """A solver that stops at a cost of (M + m) a^2/2 leaves an acceleration error a: permanently
    while the body slides, until the next step while it sticks."""
    off, step = math.sqrt(2 * contact.solver_tolerance), contact.step
    slid = float(motion.problem.motion.sliding_time)
    way = off * (0.5 * slid**2 * motion.count + step * motion.duration)
    speed = off * (slid + step)
    arm = shortest_arm(motion.problem)
    return {
        **dict.fromkeys((*PLACES, "sideways"), way),
        **dict.fromkeys(VELOCITIES, speed),
        "heading": way / arm,
        "heading_rate": speed / arm,
        "friction_force": motion.mass * (off + speed / step),
    }


def contact_deflection(motion: LineMotion, contact: SoftContact) -> Bounds:
    """Contacts whose static penetration changes with their normal force, quasi-statically up to the
    calibrated factors."""
    if contact.normal is None:
        return {}
    bent = _deflection(motion, contact, contact.normal)
    capsule, height = motion.problem.setup.capsule, contact.normal.height
    turn = _turn(motion, contact, contact.normal, bent.tilt_across)
    factor = soft_contact.QUASI_STATIC_FACTOR * capsule.friction
    velocity = factor * bent.speed + height * bent.tilt * contact.contact_rate
    way = factor * bent.lowered + height * bent.tilt
    push, lasting = _spin_push(motion, contact.normal, bent.start_lean)
    velocity, way = velocity + push * lasting, way + 0.5 * push * lasting**2
    # The slider's own weight pulls it down its tilted track.
    pull = capsule.slider_mass / contact.armature * capsule.gravity * bent.lean
    slid = 0.5 * pull * motion.duration**2
    shifted = slid * np.abs(load_fraction_slopes(motion.problem) @ motion.along) * capsule.weight
    swung = soft_contact.OVERSHOOT_FACTOR * bent.inertial_loads
    loads = swung + bent.moment_loads + shifted
    swinging = soft_contact.OVERSHOOT_FACTOR * capsule.friction * motion.mass * bent.acceleration
    return {
        "stroke": slid,
        "stroke_rate": pull * motion.duration,
        **dict.fromkeys(VELOCITIES, velocity),
        **dict.fromkeys(PLACES, way * motion.count),
        "friction_force": swinging + motion.mass * velocity / contact.step,
        **dict(zip(NORMAL_FORCES, loads.tolist(), strict=True)),
        "heading": turn * motion.count,
        "heading_rate": turn * contact.contact_rate + velocity / shortest_arm(motion.problem),
        "sideways": (way + turn * bent.stroke) * motion.count,
    }


def tangential_normal_coupling(motion: LineMotion, contact: SoftContact) -> Bounds:
    """A normal force that a slip acceleration a [m/s^2] changes by kappa f a [N], until the
    contacts' deflection has taken it up; and its error from the rounding of their depth."""
    if contact.normal is None:
        return {}
    problem, capsule, normal = motion.problem, motion.problem.setup.capsule, contact.normal
    reach = float(np.hypot(*np.asarray(capsule.supports).T).max())
    steady, sudden, growing = _coupled_loads(motion, contact, normal, reach)
    off = soft_contact.OVERSHOOT_FACTOR * steady
    off += DEPTH_ROUNDINGS * ROUNDOFF * reach / normal.compliance
    lowered, rate = normal.compliance * (sudden + steady), contact.contact_rate
    factor = soft_contact.QUASI_STATIC_FACTOR * capsule.friction
    velocity = factor * (lowered * rate + normal.compliance * steady / contact.step)
    way = factor * (lowered + normal.compliance * growing)
    lever = normal.tilt_inertia * float(np.abs(load_fraction_slopes(problem)).sum())
    turn = factor * lowered * (lever + motion.mass * reach) / capsule.inertia
    return {
        **dict.fromkeys(NORMAL_FORCES, off + sudden),
        "friction_force": 3 * capsule.friction * off + motion.mass * velocity / contact.step,
        **dict.fromkeys((*PLACES, "sideways"), way),
        **dict.fromkeys(VELOCITIES, velocity),
        "heading": turn,
        "heading_rate": turn * rate,
    }


def centre_height(motion: LineMotion, contact: SoftContact) -> Bounds:
    """Error of a centre of mass at the height h, which the source leaves out: friction has a moment
    f W h about it and shifts load along its line; not sideways, so the motion on a line is the
    same."""
    if contact.normal is None or not contact.normal.height:
        return {}
    capsule = motion.problem.setup.capsule
    moment = contact.normal.height * capsule.friction * capsule.weight
    shift = moment * np.abs(load_fraction_slopes(motion.problem) @ motion.along)
    return dict(zip(NORMAL_FORCES, shift.tolist(), strict=True))


MECHANISMS: Mapping[str, Callable[[LineMotion, SoftContact], Bounds]] = MappingProxyType(
    {
        "drift of stiction": stiction_drift,
        "armature": slider_armature,
        "solver": solver_accuracy,
        "contact deflection": contact_deflection,
        "tangential–normal coupling": tangential_normal_coupling,
        "height of the centre of mass": centre_height,
    }
)


def _coupled_loads(
    motion: LineMotion, contact: SoftContact, normal: NormalContact, reach: float
) -> tuple[float, float, float]:
    """Changes of a normal force [N] by the coupling: while the slip accelerates, where a body whose
    supports are at most `reach` [m] from C starts to slide at once, and what has grown with the
    slip of a manoeuvre by its end."""
    setup, friction = motion.problem.setup, motion.problem.setup.capsule.friction
    acceleration, slip = setup.capsule.gravity * friction, 0.0
    if motion.line is not None:
        closed = motion.line.closed
        acceleration, slip = max(closed.backward, closed.braking), closed.backward * motion.line.t1
    started = math.hypot(*setup.velocity) + abs(setup.heading_rate) * reach
    altered = normal.coupling * friction
    return altered * acceleration, altered * started / contact.step, altered * slip / contact.step


def _deflection(motion: LineMotion, contact: SoftContact, normal: NormalContact) -> Deflection:
    """The quasi-static deflections of `motion`.

    Friction that starts or ends, acting below C, tilts the body, which is at rest again within some
    steps: only the tilt remains, and a turn by f I/J of its part across the motion.
    """
    capsule, compliance = motion.problem.setup.capsule, normal.compliance
    times, loads, slid = motion.loads()
    depth = compliance * float(loads.max()) + normal.height
    tilt, tilt_across, moment_loads = _tilt(motion, loads, compliance, depth)
    height = -compliance * np.sum(loads**2, axis=0) / capsule.weight
    rise = np.gradient(height, times)
    tipped_height = 2 * compliance * float(moment_loads.max())
    leans = np.hypot(*(compliance * load_fraction_slopes(motion.problem).T @ loads))
    return Deflection(
        lowered=float(np.abs(height - height[0]).max()) + tipped_height,
        speed=float(np.abs(rise).max()) + tipped_height * contact.contact_rate,
        acceleration=float(np.abs(np.gradient(rise, times)).max()),
        tilt=tilt,
        tilt_across=tilt_across,
        lean=float(leans.max()),
        start_lean=float(leans[0]),
        moment_loads=moment_loads,
        inertial_loads=_inertial_loads(motion, normal, times, loads, slid),
        stroke=float(np.abs(slid).max()),
    )


def _tilt(
    motion: LineMotion, loads: Array, compliance: float, depth: float
) -> tuple[float, float, Array]:
    """Largest change of the body's tilt since the start under `loads` [N], shape (3, n), and its
    part across the line, friction being `depth` [m] below C; and the loads that the moment of
    friction shifts [N], shape (3,)."""
    capsule, along = motion.problem.setup.capsule, motion.along
    slopes, across = load_fraction_slopes(motion.problem), np.array([-along[1], along[0]])
    moment = capsule.friction * capsule.weight * depth
    tilts = compliance * slopes.T @ (loads - loads[:, :1])
    tipped = compliance * moment * slopes.T @ slopes @ along
    tilt = float(np.hypot(*tilts).max() + np.hypot(*tipped))
    tilt_across = float(np.abs(across @ tilts).max() + abs(across @ tipped))
    return tilt, tilt_across, moment * np.abs(slopes @ along)


def _turn(
    motion: LineMotion, contact: SoftContact, normal: NormalContact, tilt_across: float
) -> float:
    """Turn of the body [rad] while it tilts across the line by `tilt_across`."""
    capsule, line = motion.problem.setup.capsule, motion.line
    part = soft_contact.QUASI_STATIC_FACTOR * capsule.friction / capsule.inertia
    turn = part * normal.tilt_inertia * tilt_across
    if normal.height and line is not None:
        # Supports far below C slip aside while the body tips, and friction follows the slip.
        aside = normal.height * tilt_across * contact.contact_rate / line.closed.backward
        moment = capsule.friction * capsule.weight * normal.height
        turn += moment / capsule.inertia * aside * line.t_star
    return turn


def _spin_push(motion: LineMotion, normal: NormalContact, lean: float) -> tuple[float, float]:
    """Acceleration [m/s^2] of a spinning body that leans, and how long it lasts [s]: its inertias
    differ, so a tilted body is out of balance, and the loads change."""
    if not motion.coasting or motion.problem.motion.centre is None:
        return 0.0, 0.0
    capsule, coasting = motion.problem.setup.capsule, motion.problem.motion
    moment = abs(normal.tilt_inertia - capsule.inertia) * coasting.rate**2 * lean
    changed = moment * float(np.abs(load_fraction_slopes(motion.problem)).sum())
    return capsule.friction * changed / motion.mass, float(coasting.sliding_time)


def _inertial_loads(
    motion: LineMotion, normal: NormalContact, times: Array, loads: Array, slid: Array
) -> Array:
    """Largest change of each normal force [N], shape (3,), by the inertia of body and slider that
    follow the deflections under `loads` [N], shape (3, n), the slider having gone `slid` [m]."""
    setup, capsule = motion.problem.setup, motion.problem.setup.capsule
    depths = normal.compliance * loads
    corners = np.asarray(capsule.supports)
    # Forces at the supports that give the body its vertical and its two angular accelerations.
    lift = np.linalg.inv(np.column_stack([np.ones(3), corners[:, 1], -corners[:, 0]]))
    inertia = np.diag([capsule.body_mass, normal.tilt_inertia, normal.tilt_inertia])
    fractions = load_fractions(capsule, np.asarray(setup.slider) + slid[:, None] * motion.along).T
    body = lift.T @ inertia @ lift @ _second(depths, times)
    slider = capsule.slider_mass * _second(np.sum(fractions * depths, axis=0), times)
    return np.asarray((np.abs(body) + np.abs(fractions * slider)).max(axis=1))


def _second(values: Array, times: Array) -> Array:
    """Second derivative along the last axis."""
    return np.gradient(np.gradient(values, times, axis=-1), times, axis=-1)
