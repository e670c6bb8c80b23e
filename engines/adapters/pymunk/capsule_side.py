"""The capsule seen from the side in pymunk, for motions on one line.

It is a body on the ground under gravity that stands on two feet, where the hindmost and the
foremost support are on the line. Their normal forces are the engine's own, from its contacts:
together the weight, and their centre the centre of pressure. The side view cannot tell how three
supports carry that; statics across the line does.
"""

from __future__ import annotations

import cmath
import math

import numpy as np
import pymunk

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import load_fractions
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.pymunk.assembly import (
    NO_TURNING,
    Assembly,
    View,
    pin_joint,
    slider_start_speed,
)
from plumbob.engines.adapters.pymunk.simulation import vector
from plumbob.engines.trajectory import ByName
from plumbob.models.tripod_capsule.observed import observed_on_a_line

FOOT = 1.0  # [m] radius of a foot: the larger, the less a rounded contact tilts its normal
DEPTH = 1e-9  # [m] overlap of feet and ground: shapes are in contact only if they overlap
SLOP = 1e-6  # [m] overlap that pymunk does not correct
GROUND = 1e3  # [m] length of the ground to each side


def from_the_side(setup: CapsuleSetup) -> View:
    """The capsule seen from the side: body and slider at height zero, x along the line, y up. C
    starts at the origin."""
    capsule = setup.capsule
    space = pymunk.Space()
    space.gravity = (setup.pull, -setup.press)
    space.collision_slop = SLOP
    start = along(setup, setup.slider)
    speed = along(setup, setup.velocity)
    body = pymunk.Body(capsule.body_mass, side_moment(setup))
    slider = pymunk.Body(capsule.slider_mass, NO_TURNING)
    body.position = (0.0, -DEPTH)
    slider.position = (start, -DEPTH)
    body.velocity, slider.velocity = (speed, 0.0), (speed + slider_start_speed(setup), 0.0)
    ground = pymunk.Segment(space.static_body, (-GROUND, 0.0), (GROUND, 0.0), 0.0)
    feet = [pymunk.Circle(body, FOOT, (x, FOOT)) for x in foot_reach(setup)]
    # pymunk multiplies the friction of two shapes.
    ground.friction = 1.0
    for foot in feet:
        foot.friction = capsule.friction
    joint = pin_joint(body, slider, complex(start))
    space.add(body, ground, *feet, slider, joint)

    def shown() -> ByName:
        """The observables of the pose."""
        gone = body.position.x
        pace = body.velocity.x
        slid = slider.position.x - gone - start
        slid_rate = slider.velocity.x - pace
        return observed_on_a_line(setup, gone, pace, slid, slid_rate)

    assembly = Assembly(space, body, slider, joint, complex(start))
    return View(assembly, shown, lambda: _normal_forces(setup, assembly, feet))


def along(setup: CapsuleSetup, vector: tuple[float, float]) -> float:
    """The component along the slider's line of a vector in the axes of the body."""
    return (complex(*vector) * cmath.rect(1.0, -setup.direction)).real


def foot_reach(setup: CapsuleSetup) -> tuple[float, float]:
    """The places of the hindmost and the foremost support along the line, relative to C [m]."""
    places = [along(setup, support) for support in setup.capsule.supports]
    return min(places), max(places)


def side_moment(setup: CapsuleSetup) -> float:
    """The moment of inertia about the axis across the line [kg m^2]: the moment of two points with
    half of the body's mass, one at each foot. It has no effect if no height changes."""
    hind, fore = foot_reach(setup)
    return setup.capsule.body_mass * ((fore - hind) / 2) ** 2


def _normal_forces(setup: CapsuleSetup, parts: Assembly, feet: list[pymunk.Circle]) -> Array:
    """The normal forces N_i in the last step [N]. The loads of the two feet give the sum of the
    forces and the centre of pressure along the line; statics divides them among three supports."""
    impulses: dict[pymunk.Shape, float] = {}  # [N s]

    def keep(arbiter: pymunk.Arbiter) -> None:
        """Keeps the vertical impulse of a contact for both of its shapes."""
        impulses.update(dict.fromkeys(arbiter.shapes, abs(arbiter.total_impulse.y)))

    parts.body.each_arbiter(keep)
    hind, fore = (impulses.get(foot, 0.0) / parts.space.current_time_step for foot in feet)
    total = hind + fore or math.nan
    hind_place, fore_place = foot_reach(setup)
    line = cmath.rect(1.0, setup.direction)
    across = setup.capsule.mass_ratio * (complex(*setup.slider) / line).imag
    along_line = (hind * hind_place + fore * fore_place) / total
    centre_of_pressure = complex(along_line, across) * line
    fractions = load_fractions(setup.capsule, np.array(vector(centre_of_pressure)))
    return total * fractions
