"""The capsule seen from the side in pymunk, for motions on one line, and what is read off it.

It is a body on the ground under gravity that stands on two feet, where the hindmost and the
foremost support are on the line. Their normal forces and friction are the engine's own, from its
contacts: together the weight, and their centre the centre of pressure. The side view cannot tell
how three supports carry that; statics across the line does.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pymunk

from plumbob.analytic.systems.capsule import NORMAL_FORCES
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.pymunk.assembly import NO_TURNING, Assembly, pin_joint
from plumbob.engines.adapters.three_feet import Pose, observed
from plumbob.engines.trajectory import ByName

FOOT = 1.0  # [m] radius of a foot: the larger, the less a rounded contact tilts its normal
DEPTH = 1e-9  # [m] overlap of feet and ground: only what overlaps is in contact
SLOP = 1e-6  # [m] of overlap that pymunk leaves alone
GROUND = 1e3  # [m] to each side
Read = Callable[[], ByName]
KEPT = ("heading", "sideways", "heading_rate", "body_angle")  # by the view itself


@dataclass(frozen=True)
class Stand:
    """A capsule seen from the side and the two feet that it stands on."""

    assembly: Assembly
    reach: tuple[float, float]  # of the feet from C along the line [m]
    feet: tuple[pymunk.Circle, pymunk.Circle]


def standing(setup: CapsuleSetup) -> Stand:
    """Body and slider at height zero, x along the line and y up; C starts at the origin."""
    capsule, space = setup.capsule, pymunk.Space()
    space.gravity, space.collision_slop = (setup.pull, -setup.press), SLOP
    start, speed = along(setup, setup.slider), along(setup, setup.velocity)
    body = pymunk.Body(capsule.body_mass, side_moment(setup))
    slider = pymunk.Body(capsule.slider_mass, NO_TURNING)
    body.position, slider.position = (0.0, -DEPTH), (start, -DEPTH)
    pushed = 0.0
    if (velocity := setup.relative_velocity) is not None:
        pushed = float(velocity(np.zeros(1))[0])
    body.velocity, slider.velocity = (speed, 0.0), (speed + pushed, 0.0)
    ground = pymunk.Segment(space.static_body, (-GROUND, 0.0), (GROUND, 0.0), 0.0)
    ground.friction = 1.0  # a contact's is the product of the two
    reach = foot_reach(setup)
    hind, fore = (pymunk.Circle(body, FOOT, (x, FOOT)) for x in reach)
    hind.friction = fore.friction = capsule.friction
    joint = pin_joint(body, slider, complex(start))
    space.add(body, slider, ground, hind, fore, joint)
    return Stand(Assembly(space, body, 0j, slider, joint), reach, (hind, fore))


def along(setup: CapsuleSetup, vector: tuple[float, float]) -> float:
    """Component along the line of a vector in body axes."""
    x, y = vector
    return math.cos(setup.direction) * x + math.sin(setup.direction) * y


def foot_reach(setup: CapsuleSetup) -> tuple[float, float]:
    """Places of the hindmost and the foremost support along the line, from C [m]."""
    places = [along(setup, support) for support in setup.capsule.supports]
    return min(places), max(places)


def side_moment(setup: CapsuleSetup) -> float:
    """Moment of inertia about the axis across the line [kg m^2], that of half the body's mass at
    each foot; it has no part in a motion without heights."""
    hind, fore = foot_reach(setup)
    return setup.capsule.body_mass * ((fore - hind) / 2) ** 2


def _on_the_line(setup: CapsuleSetup, stand: Stand) -> ByName:
    """The observables that a pose on the line shows."""
    body, slider = stand.assembly.body, stand.assembly.slider
    gone, pace = body.position.x, body.velocity.x
    line = cmath.rect(1.0, setup.heading + setup.direction)
    pose = Pose(
        gone * line,
        pace * line,
        setup.heading,
        0.0,
        slider.position.x - gone - along(setup, setup.slider),
        slider.velocity.x - pace,
    )
    return {name: v for name, v in observed(setup, pose).items() if name not in KEPT}


def readings(setup: CapsuleSetup, stand: Stand) -> tuple[Read, Read | None]:
    """Those of `_on_the_line`; along a line the N_i of the last step too, and, once the step that
    follows is done, the friction in it and the force on the slider, which is the joint's impulse
    over the step."""
    assembly, sliding = stand.assembly, 0.0
    slider, loads = assembly.slider, _normal_forces(setup, stand)

    def read() -> ByName:
        nonlocal sliding
        sliding = slider.velocity.x
        shown = _on_the_line(setup, stand)
        return shown if setup.in_plane else {**shown, **loads()}

    def following() -> ByName:
        step = assembly.space.current_time_step
        return {
            "friction_force": sum(force for force, _ in _contact_forces(stand)),
            "driving_force": slider.mass * ((slider.velocity.x - sliding) / step - setup.pull),
        }

    return read, None if setup.in_plane else following


def _normal_forces(setup: CapsuleSetup, stand: Stand) -> Read:
    """N_i in the last step [N]: the loads of both feet and their centre of pressure, carried by
    three supports by statics, across the line too."""
    capsule, unit = setup.capsule, cmath.rect(1.0, setup.direction)
    across = capsule.mass_ratio * (complex(*setup.slider) / unit).imag
    supports = np.array([complex(*support) for support in capsule.supports]) / unit
    share = np.linalg.inv([np.ones(3), supports.real, supports.imag])

    def read() -> ByName:
        (_, hind), (_, fore) = _contact_forces(stand)
        both, turning = hind + fore, hind * stand.reach[0] + fore * stand.reach[1]
        loads = share @ [both, turning, both * across] if both else np.full(3, math.nan)
        return dict(zip(NORMAL_FORCES, loads.tolist(), strict=True))

    return read


def _contact_forces(stand: Stand) -> list[tuple[float, float]]:
    """Force of the ground on each foot [N], along and up, in the last step."""
    step = stand.assembly.space.current_time_step
    forces: dict[pymunk.Shape, tuple[float, float]] = {}

    def note(arbiter: pymunk.Arbiter) -> None:
        x, y = arbiter.total_impulse
        upwards = math.copysign(1.0 / step, y)
        for shape in arbiter.shapes:
            forces[shape] = (upwards * x, upwards * y)

    stand.assembly.body.each_arbiter(note)
    return [forces.get(foot, (0.0, 0.0)) for foot in stand.feet]
