"""The capsule seen from above in pymunk: on feet or on bare pivots, and what is read off it.

Feet: friction that converges. A joint to the ground with a largest force is Coulomb friction only
where it is solved alone, that is for the point mass that it holds: clamped on a rigid body off its
centre, its impulse has the direction of K^-1 v, not of v. So each support is a small body that
cannot turn, with a friction joint to the ground and a pin to the body, and the solver's iterations
carry the forces from one to the other. The feet's masses, and what they add to the inertia, are
taken off the body.

A foot may stand beside its pin: that has no part in friction, which acts on the body at the pin.
While the body turns, a pin has to close its opening, or the feet lag behind the turn. While the
body does not turn, a pin must not close: sticking feet cannot follow, closing strains them against
each other more in every step, and that uses friction up (near the friction limit the body drifts,
0.1 mm in 10 s at 0.999 of it).

Pivots: friction that does not converge. The naive model, here to be measured: the solver clamps the
impulse that would bring the support to rest, which on a rigid body off its centre is not along the
support's velocity. No step and no number of iterations fixes it.
"""

from __future__ import annotations

import cmath
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pymunk

from plumbob.analytic.systems.capsule import CORNERS, NORMAL_FORCES, Capsule, normal_forces
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.pymunk.assembly import (
    NO_TURNING,
    Assembly,
    friction_joint,
    pin_joint,
    place_part,
    vector,
)
from plumbob.engines.adapters.three_feet import observed
from plumbob.engines.trajectory import ByName

FOOT_FRACTION = 0.1  # of the body's mass in each foot: with lighter feet the solver is slower
LEAST_INERTIA = 0.25  # fraction of the body's inertia that the feet leave to it
NO_CLOSING = 1.0  # error_bias of a joint that closes nothing
SetLimits = Callable[[float, float], None]
"""Sets the friction limits for a slider at (x, y) from C [m, body axes]."""
Read = Callable[[], ByName]


def foot_mass(capsule: Capsule) -> float:
    """Mass of a foot [kg]: FOOT_FRACTION of the body's, or less where the body would keep less
    than LEAST_INERTIA of its inertia.

    With the feet's masses m_f the body keeps J - m_f sum A_i^2 - m_b c^2, c its own centre of mass,
    and m_b c^2 <= 3 m_f^2 sum A_i^2 / m_b.
    """
    spread = float(np.square(capsule.supports).sum())
    most = (1.0 - LEAST_INERTIA) * capsule.inertia / (capsule.body_mass * spread)
    return capsule.body_mass * min(FOOT_FRACTION, most / (1.0 + 3.0 * most))


def on_feet(setup: CapsuleSetup, step: float, turning: bool) -> Assembly:
    """The capsule on three feet, in a motion in which it turns or not; `friction_limits` sets
    their friction."""
    capsule = setup.capsule
    anchors = [complex(x, y) for x, y in capsule.supports]
    mass = foot_mass(capsule)
    core_mass = capsule.body_mass - 3 * mass
    core_centre = -mass * sum(anchors) / core_mass
    moment = (
        capsule.inertia
        - core_mass * abs(core_centre) ** 2
        - mass * sum(abs(a) ** 2 for a in anchors)
    )
    bare = _body_and_slider(setup, core_mass, moment, core_centre, step)
    pins, joints = [], []
    for anchor in anchors:
        foot = pymunk.Body(mass, NO_TURNING)
        place_part(setup, foot, anchor, core_centre, step)
        pins.append(pin_joint(bare.body, foot, anchor - core_centre))
        if not turning:
            pins[-1].error_bias = NO_CLOSING
        joints.append(friction_joint(bare.space, foot, 0j))
        bare.space.add(foot)
    bare.space.add(*pins, *joints)
    return replace(bare, pins=tuple(pins), friction_joints=tuple(joints))


def on_pivots(setup: CapsuleSetup, step: float) -> Assembly:
    """The capsule on three friction joints to the ground; `friction_limits` sets their friction."""
    capsule = setup.capsule
    bare = _body_and_slider(setup, capsule.body_mass, capsule.inertia, 0j, step)
    joints = [friction_joint(bare.space, bare.body, complex(x, y)) for x, y in capsule.supports]
    bare.space.add(*joints)
    return replace(bare, friction_joints=tuple(joints))


def _body_and_slider(
    setup: CapsuleSetup, mass: float, moment: float, centre_of_mass: complex, step: float
) -> Assembly:
    """Space with a body of `mass` [kg] and `moment` [kg m^2], its centre of mass at
    `centre_of_mass` from C [m, body axes], and the slider pinned to it; C starts at the origin."""
    space, line = pymunk.Space(), setup.heading + setup.direction
    space.gravity = vector(cmath.rect(setup.pull, line))
    body = pymunk.Body(mass, moment)
    slider = pymunk.Body(setup.capsule.slider_mass, NO_TURNING)
    start = complex(*setup.slider)
    place_part(setup, body, centre_of_mass, centre_of_mass, step)
    place_part(setup, slider, start, centre_of_mass, step)
    body.angle, body.angular_velocity = setup.heading, setup.heading_rate
    if (velocity := setup.relative_velocity) is not None:
        along = cmath.rect(float(velocity(np.zeros(1))[0]), line)
        slider.velocity = vector(complex(*slider.velocity) + along)
    joint = pin_joint(body, slider, start - centre_of_mass)
    space.add(body, slider, joint)
    return Assembly(space, body, -centre_of_mass, slider, joint)


def static_loads(setup: CapsuleSetup) -> Callable[[float, float], list[float]]:
    """The N_i of statics [N] for a slider at (x, y) from C [m, body axes], in which they are
    affine: this view has no contacts."""
    at_centre, *ahead = normal_forces(setup.capsule, CORNERS) * (
        setup.press / setup.capsule.gravity
    )
    rows = np.stack([at_centre, *(forces - at_centre for forces in ahead)], axis=1).tolist()
    return lambda x, y: [c + cx * x + cy * y for c, cx, cy in rows]


def friction_limits(setup: CapsuleSetup, joints: tuple[pymunk.PivotJoint, ...]) -> SetLimits:
    """Function of the slider's place from C [m, body axes] that sets the largest force of each
    support's joint, f N_i; called once for the start."""
    loads, friction = static_loads(setup), setup.capsule.friction

    def set_limits(x: float, y: float) -> None:
        for joint, load in zip(joints, loads(x, y), strict=True):
            joint.max_force = max(friction * load, 0.0)

    set_limits(*setup.slider)
    return set_limits


def readings(setup: CapsuleSetup, assembly: Assembly) -> tuple[Read, Read | None]:
    """The observables that a pose shows; along a line the N_i of statics too, and, once the step
    that follows is done, the friction in it and the force on the slider.

    pymunk gives the magnitude of a joint's impulse and not its direction: friction is what the
    momentum gains beyond gravity, and the driving force what the slider's gains.
    """
    slider, back = assembly.slider, cmath.exp(-1j * (setup.heading + setup.direction))
    loads, before, slid = static_loads(setup), 0j, 0j
    pulled = sum(part.mass for part in assembly.parts) * setup.pull

    def read() -> ByName:
        nonlocal before, slid
        before, slid = assembly.momentum, complex(*slider.velocity)
        shown = observed(setup, assembly.pose(setup))
        if not setup.in_plane:
            place = vector(assembly.motion_of_slider[0])
            shown |= zip(NORMAL_FORCES, loads(*place), strict=True)
        return shown

    def following() -> ByName:
        step, gained = assembly.space.current_time_step, (assembly.momentum - before) * back
        pushed = slider.mass * (complex(*slider.velocity) - slid) * back
        return {
            "friction_force": gained.real / step - pulled,
            "driving_force": pushed.real / step - slider.mass * setup.pull,
        }

    return read, None if setup.in_plane else following
