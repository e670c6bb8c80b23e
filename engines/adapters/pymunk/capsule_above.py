"""The capsule in pymunk, seen from above: on feet or on bare pivots, with their friction.

Feet: friction that converges. A joint to the ground with a largest force is Coulomb friction only
if it acts on a point mass. On a rigid body, away from its centre, the clamped impulse has the
direction of K^-1 v, and not of v. So each support is a small body that cannot turn, with a friction
joint to the ground and a pin to the body; the solver's iterations carry the forces from one to the
other. The masses of the feet, and their contribution to the moment of inertia, are subtracted from
the body.

A foot may be displaced from its pin without effect on friction, which acts on the body at the pin.
While the body turns, pins must close their openings; otherwise the feet lag behind the rotation.
While the body does not turn, pins must not close: sticking feet cannot follow, so that closing
strains them against each other more in every step and uses up friction (at 0.999 of the friction
limit the body then drifts by 0.1 mm in 10 s).

Pivots: friction that does not converge. It is the naive model, and is here to be measured: the
solver clamps the impulse that would bring the support to rest, which is not along the support's
velocity. No step and no number of iterations corrects it."""

from __future__ import annotations

import cmath
from collections.abc import Callable

import numpy as np
import pymunk

from plumbob.analytic.systems.capsule import Capsule, load_gradient, normal_forces
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.pymunk.assembly import (
    NO_TURNING,
    Assembly,
    View,
    friction_joint,
    pin_joint,
    place_part,
    slider_start_speed,
)
from plumbob.engines.adapters.pymunk.simulation import vector
from plumbob.models.tripod_capsule.observed import pose_observables

# Ratio of a foot's mass to the body's mass: with lighter feet the solver is slower.
FOOT_FRACTION = 0.1
LEAST_INERTIA = 0.25  # smallest fraction of the moment of inertia that stays with the body
NO_CLOSING = 1.0  # error_bias of a joint that never closes its opening


def foot_mass(capsule: Capsule) -> float:
    """The mass of a foot [kg]: FOOT_FRACTION of the body's mass, or less if the body would
    otherwise keep less than LEAST_INERTIA of its moment of inertia.

    With feet of mass m_f at A_i from C, a body of mass m_b and moment of inertia J keeps
    J - m_f sum A_i^2 - m_b c^2, where c is the distance of its new centre of mass from C, and
    m_b c^2 <= 3 m_f^2 sum A_i^2 / m_b."""
    squares = float(np.square(capsule.supports).sum())
    ratio = (1.0 - LEAST_INERTIA) * capsule.inertia / (capsule.body_mass * squares)
    return capsule.body_mass * min(FOOT_FRACTION, ratio / (1.0 + 3.0 * ratio))


def from_above(setup: CapsuleSetup, step: float, feet: bool, turning: bool) -> View:
    """The capsule seen from above, on feet or on bare pivots. `turning` says whether it turns
    during the motion. This view has no contacts: the normal forces N_i are those of statics, and
    limit friction."""
    mass = foot_mass(setup.capsule) if feet else 0.0
    assembly = _body_and_slider(setup, mass, step)
    friction = setup.capsule.friction
    space = assembly.space
    body = assembly.body
    centre = -assembly.centre
    pins = []
    joints = []
    for anchor in (complex(x, y) for x, y in setup.capsule.supports):
        if not feet:
            joints.append(friction_joint(space, body, anchor))
            continue
        foot = pymunk.Body(mass, NO_TURNING)
        place_part(setup, foot, anchor, centre, step)
        pins.append(pin_joint(body, foot, anchor - centre))
        if not turning:
            pins[-1].error_bias = NO_CLOSING
        joints.append(friction_joint(space, foot, 0j))
        space.add(foot)
    space.add(*pins, *joints)
    loads = static_loads(setup)

    def set_limits(place: complex) -> None:
        """Sets the largest friction of each support for a slider at this place."""
        for joint, load in zip(joints, loads(place), strict=True):
            joint.max_force = max(friction * load, 0.0)

    set_limits(assembly.start)
    return View(
        assembly,
        lambda: pose_observables(setup, assembly.pose),
        lambda: loads(assembly.motion[2]),
        set_limits,
    )


def _body_and_slider(setup: CapsuleSetup, mass: float, step: float) -> Assembly:
    """The body without its three feet of `mass` [kg], and the slider pinned to it, in a new space;
    C starts at the origin."""
    capsule = setup.capsule
    space = pymunk.Space()
    start = complex(*setup.slider)
    space.gravity = vector(cmath.rect(setup.pull, setup.heading + setup.direction))
    anchors = [complex(x, y) for x, y in capsule.supports]
    body_mass = capsule.body_mass - 3 * mass
    centre = -mass * sum(anchors) / body_mass  # centre of mass without the feet, from C
    feet_inertia = mass * sum(abs(anchor) ** 2 for anchor in anchors)
    moment = capsule.inertia - body_mass * abs(centre) ** 2 - feet_inertia
    body = pymunk.Body(body_mass, moment)
    slider = pymunk.Body(capsule.slider_mass, NO_TURNING)
    place_part(setup, body, centre, centre, step)
    place_part(setup, slider, start, centre, step)
    body.angle = setup.heading
    body.angular_velocity = setup.heading_rate
    pushed = cmath.rect(slider_start_speed(setup), setup.heading + setup.direction)
    slider.velocity = vector(complex(*slider.velocity) + pushed)
    joint = pin_joint(body, slider, start - centre)
    line = cmath.rect(1.0, setup.direction)
    space.add(body, slider, joint)
    return Assembly(space, body, slider, joint, start, line, -centre)


def static_loads(setup: CapsuleSetup) -> Callable[[complex], list[float]]:
    """A function from the slider's place x + iy relative to C [m], in the axes of the body, to the
    normal forces N_i of statics [N], which are affine in the place."""
    capsule = setup.capsule
    scale = setup.press / setup.capsule.gravity
    forces = [normal_forces(capsule, np.zeros(2)), *load_gradient(capsule)]
    rows = (scale * np.column_stack(forces)).tolist()

    def loads(place: complex) -> list[float]:
        """The normal forces for a slider at this place."""
        x = place.real
        y = place.imag
        return [c + cx * x + cy * y for c, cx, cy in rows]

    return loads
