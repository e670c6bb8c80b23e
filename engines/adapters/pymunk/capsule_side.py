"""The capsule seen from the side: a body on the ground under gravity, for motions on one line.

It stands on two feet, where the hindmost and the foremost support are on the line. Their normal
forces and friction are the engine's own, from its contacts: together the weight, and their centre
the centre of pressure. How three supports share that, the side view has no room for; statics across
the line says it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pymunk

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.pymunk.capsule_space import NO_TURNING, Assembly, pinned
from plumbob.engines.adapters.pymunk.capsule_sweeps import left_by_sweep, pin

FOOT = 1.0  # [m] radius of a foot: the larger, the less a rounded contact tilts its normal
DEPTH = 1e-9  # [m] to which the feet stand in the ground: only what overlaps is in contact
SLOP = 1e-6  # [m] of overlap that pymunk leaves alone
GROUND = 1e3  # [m] to each side


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
    joint = pinned(body, slider, complex(start))
    space.add(body, slider, ground, hind, fore, joint)
    return Stand(Assembly(space, body, 0j, slider, joint), reach, (hind, fore))


def along(setup: CapsuleSetup, vector: tuple[float, float]) -> float:
    """What a vector in body axes has along the line."""
    x, y = vector
    return math.cos(setup.direction) * x + math.sin(setup.direction) * y


def foot_reach(setup: CapsuleSetup) -> tuple[float, float]:
    """Places of the hindmost and the foremost support along the line, from C [m]."""
    places = [along(setup, support) for support in setup.capsule.supports]
    return min(places), max(places)


def side_moment(setup: CapsuleSetup) -> float:
    """Moment of inertia about the axis across the line [kg m^2], which has no part in a motion
    without heights: that of half the body's mass at each foot, or so."""
    hind, fore = foot_reach(setup)
    return setup.capsule.body_mass * ((fore - hind) / 2) ** 2


def side_left_by_sweep(setup: CapsuleSetup, place: float) -> float:
    """Largest share of a velocity that one sweep of the solver leaves while both contacts hold,
    the slider at `place` along the line from C [m]."""
    mass, slider = setup.capsule.body_mass, setup.capsule.slider_mass
    rows: list[Array] = []
    for reach in foot_reach(setup):
        contact = pin(5, np.array([reach, 0.0]), 3)
        contact[:, 3:] = 0.0
        rows += [contact[1:], contact[:1]]
    masses = [mass, mass, side_moment(setup), slider, slider]
    return left_by_sweep(masses, [*rows, pin(5, np.array([place, 0.0]), 3)])
