"""The relation of a capsule to tripod_capsule.xml and turning.xml."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_setup import CapsuleProblem, CapsuleSetup
from plumbob.models.idealisations import Idealisations, Velocity
from plumbob.models.model_file import ModelFile
from plumbob.models.tripod_capsule.observed import largest_magnitudes, observe, start_velocity

ARMATURE_RATIO = 1e10  # least ratio of the slider's armature to its mass
PATH_SAMPLES = 2001  # samples of the slider's path, for the maximum of a smooth function on it
# [kg m^2] moments of inertia of the slider: MuJoCo requires more than 1e-15
SLIDER_INERTIA = 1e-14


def fill(spec: Any, problem: CapsuleProblem) -> None:
    """Writes the numbers of a capsule into an MjSpec of tripod_capsule.xml, or of turning.xml if
    the slider leaves its line. The springs of the contacts depend on the step and are not written:
    the start is that of rigid contacts."""
    setup = problem.setup
    capsule = setup.capsule
    across = tilt_inertia(problem)
    body = spec.body("body")
    spec.option.gravity = gravity(setup)
    body.mass = capsule.body_mass
    body.inertia = [across, across, capsule.inertia]
    for number, (x, y) in enumerate(capsule.supports, start=1):
        support = spec.geom(f"support_{number}")
        support.pos = [x, y, support.size[0]]
    # MuJoCo raises a friction of 0 to 1e-5: without friction the contact has one dimension.
    dimensions = 3 if capsule.friction > 0.0 else 1
    for contact in spec.pairs:
        contact.friction[:2] = capsule.friction
        contact.condim = dimensions
    slider = spec.body("slider")
    slider.pos = [*setup.slider, 0.0]
    slider.inertia = [SLIDER_INERTIA] * 3
    if setup.plane_velocity is None:
        spec.joint("slider").axis = [math.cos(setup.direction), math.sin(setup.direction), 0.0]
    set_slider(spec, setup)
    _add_start(spec, setup)


def _add_start(spec: Any, setup: CapsuleSetup) -> None:
    """Adds the keyframe of the start: C at the origin, turned by the heading, and the slider at its
    place."""
    half_angle = setup.heading / 2.0
    attitude = [math.cos(half_angle), 0.0, 0.0, math.sin(half_angle)]
    start = np.zeros(1)
    slider_rates = [float(velocity(start)[0]) for velocity in _velocities(setup).values()]
    slider_places = [0.0] * len(slider_rates)
    angular_velocity = [0.0, 0.0, setup.heading_rate]
    spec.add_key(
        name="start",
        qpos=[0.0, 0.0, 0.0, *attitude, *slider_places],
        qvel=[*start_velocity(setup), 0.0, *angular_velocity, *slider_rates],
    )


def set_slider(spec: Any, setup: CapsuleSetup) -> None:
    """Sets the slider's mass, and the armature by which its one or two joints impose its motion. A
    slider without imposed motion loses its joint: it is fixed in the body. The file's keyframe is
    deleted: the start is the scene's, at rest on contacts that have settled."""
    spec.body("slider").mass = setup.capsule.slider_mass
    for key in tuple(spec.keys):
        spec.delete(key)
    if not driven_joints(setup):
        spec.delete(spec.actuator("slider"))
        spec.delete(spec.joint("slider"))
        return
    impose(spec, armature(setup))


def impose(spec: Any, armature: float) -> None:
    """Sets the armature [kg] by which the slider's joints impose its motion."""
    for motor in spec.actuators:
        motor.gear[0] = armature
        spec.joint(motor.target).armature = armature


def driven_joints(setup: CapsuleSetup) -> tuple[str, ...]:
    """Returns the names of the joints that move the slider: one along its line, two in the plane,
    or none."""
    return tuple(_velocities(setup))


def ideal(problem: CapsuleProblem) -> Idealisations:
    """Returns the idealisation: the slider is a point, and its velocity in the body is
    prescribed."""
    return Idealisations(velocities=_velocities(problem.setup), points=("slider",))


def _velocities(setup: CapsuleSetup) -> dict[str, Velocity]:
    """Returns the prescribed velocity of each joint that moves the slider."""
    along, plane = setup.relative_velocity, setup.plane_velocity
    if along is not None:
        return {"slider": along}
    if plane is None:
        return {}
    return {
        "slider_x": lambda times: plane(times)[:, 0],
        "slider_y": lambda times: plane(times)[:, 1],
    }


def variant(problem: CapsuleProblem) -> str:
    """Returns the name of the file whose slider has two joints if the slider leaves its line;
    otherwise empty."""
    return "" if problem.setup.plane_velocity is None else "turning.xml"


def gravity(setup: CapsuleSetup) -> Array:
    """Returns gravity in the world [m/s^2]: it pulls along the line, and presses onto the plane."""
    line = setup.heading + setup.direction
    return np.array([setup.pull * math.cos(line), setup.pull * math.sin(line), -setup.press])


def armature(setup: CapsuleSetup, ratio: float = ARMATURE_RATIO) -> float:
    """Returns the armature of the slider's joint [kg]: a power of ten, at least `ratio` times the
    slider's mass."""
    return float(10.0 ** math.ceil(math.log10(ratio * setup.capsule.slider_mass)))


def tilt_inertia(problem: CapsuleProblem) -> float:
    """Returns the body's moment of inertia about axes across the vertical [kg m^2], in two digits.

    It has no effect on a motion without heights, and is free. It is at least (M + m)/3 sum |A_i -
    mu r|^2: then the square of the frequency of every tilting mode on the contacts is at most twice
    that of the vertical mode, for every triangle and every place of the slider. It is at least J/2:
    otherwise no such body could exist.
    """
    capsule = problem.setup.capsule
    centres = capsule.mass_ratio * problem.slider_places(PATH_SAMPLES)
    arms = np.asarray(capsule.supports)[None] - centres[:, None]
    sum_of_squares = float(np.square(arms).sum(axis=(1, 2)).max())
    by_modes = (capsule.body_mass + capsule.slider_mass) / 3 * sum_of_squares
    least = max(by_modes, capsule.inertia / 2)
    second_digit = 10.0 ** (math.floor(math.log10(least)) - 1)
    rounded_up = math.ceil(least / second_digit * (1 - 1e-12)) * second_digit
    return float(f"{rounded_up:.1e}")


MODEL = ModelFile(
    fill,
    observe,
    ideal,
    largest=lambda problem: largest_magnitudes(problem.setup),
    variant=variant,
)
