"""The capsule seen from above in pymunk's terms: a body with the slider pinned to it, and friction
as joints to the ground."""

from __future__ import annotations

import cmath
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pymunk

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import normal_forces
from plumbob.analytic.systems.capsule_setup import CapsuleSetup

FIRST = 1000  # sweeps where there is nothing to begin from
NO_TURNING = float("inf")  # moment of inertia of a body that only its pins carry along
Tell = Callable[[float, float], None]


@dataclass(frozen=True)
class Assembly:
    """Bodies and joints of a capsule; complex numbers are x + iy."""

    space: pymunk.Space
    body: pymunk.Body  # its origin is its own centre of mass, not C
    centre: complex  # C in axes of `body` [m]
    slider: pymunk.Body
    joint: pymunk.PivotJoint  # of `body` and `slider`
    grips: tuple[pymunk.PivotJoint, ...] = ()  # to the ground, one a support
    pins: tuple[pymunk.PivotJoint, ...] = ()  # of `body` and its other parts

    @property
    def parts(self) -> tuple[pymunk.Body, ...]:
        """Every body that moves."""
        return (self.body, self.slider, *(pin.b for pin in self.pins))


def point(value: complex) -> tuple[float, float]:
    """A plane vector as pymunk takes it."""
    return value.real, value.imag


def assembled(
    setup: CapsuleSetup, mass: float, moment: float, centre_of_mass: complex, step: float
) -> Assembly:
    """Space with a body of `mass` [kg] and `moment` [kg m^2], its centre of mass at
    `centre_of_mass` from C [m, body axes], and the slider pinned to it; C starts at the origin."""
    space, line = pymunk.Space(), setup.heading + setup.direction
    space.gravity = point(cmath.rect(setup.pull, line))
    body = pymunk.Body(mass, moment)
    slider = pymunk.Body(setup.capsule.slider_mass, NO_TURNING)
    start = complex(*setup.slider)
    place(setup, body, centre_of_mass, centre_of_mass, step)
    place(setup, slider, start, centre_of_mass, step)
    body.angle, body.angular_velocity = setup.heading, setup.heading_rate
    if (velocity := setup.relative_velocity) is not None:
        along = cmath.rect(float(velocity(np.zeros(1))[0]), line)
        slider.velocity = point(complex(*slider.velocity) + along)
    joint = pinned(body, slider, start - centre_of_mass)
    space.add(body, slider, joint)
    return Assembly(space, body, -centre_of_mass, slider, joint)


def place(
    setup: CapsuleSetup, part: pymunk.Body, anchor: complex, centre_of_mass: complex, step: float
) -> None:
    """Put `part` at its start: pinned at `anchor` to a body with this `centre_of_mass`, both from C
    [m, body axes]. A joint that closes in one step is open by what the step before opened; started
    closed, its first impulse would be a jerk."""
    turned, turn = cmath.exp(1j * setup.heading), 1j * step * setup.heading_rate
    opening = cmath.exp(-turn) * (1 + turn) - 1
    part.position = point(turned * (anchor + opening * (anchor - centre_of_mass)))
    part.velocity = point(turned * (complex(*setup.velocity) + (turn - opening) / step * anchor))


def pinned(body: pymunk.Body, part: pymunk.Body, anchor: complex) -> pymunk.PivotJoint:
    """Joint that keeps `part` at `anchor` [m, axes of `body`], closed in every step."""
    joint = pymunk.PivotJoint(body, part, point(anchor), (0.0, 0.0))
    joint.error_bias = 0.0
    return joint


def gripped(space: pymunk.Space, part: pymunk.Body, anchor: complex) -> pymunk.PivotJoint:
    """Joint that asks the point `anchor` [m, axes of `part`] for rest, wherever it is: friction,
    once its largest force is set."""
    joint = pymunk.PivotJoint(part, space.static_body, point(anchor), (0.0, 0.0))
    joint.max_bias = 0.0
    return joint


def told_normal_forces(setup: CapsuleSetup, places: Array) -> Array:
    """Normal forces N_i [N], shape (n, 3), with the slider at `places` from C [m], shape (n, 2):
    seen from above there are none, and statics has to say them."""
    return normal_forces(setup.capsule, places) * (setup.press / setup.capsule.gravity)


def told(setup: CapsuleSetup, grips: tuple[pymunk.PivotJoint, ...]) -> Tell:
    """Function of the slider's place from C [m, body axes] that tells the joints of the supports
    the most that friction can, f N_i."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    limits = setup.capsule.friction * told_normal_forces(setup, corners)
    constants, by_x, by_y = limits[0], limits[1] - limits[0], limits[2] - limits[0]
    (a, ax, ay), (b, bx, by), (c, cx, cy) = np.stack([constants, by_x, by_y], axis=1).tolist()
    first, second, third = grips

    def tell(x: float, y: float) -> None:
        first.max_force = max(a + ax * x + ay * y, 0.0)
        second.max_force = max(b + bx * x + by * y, 0.0)
        third.max_force = max(c + cx * x + cy * y, 0.0)

    tell(*setup.slider)
    return tell


def settle(assembly: Assembly, step: float) -> None:
    """Let joints and contacts find what they carry at the start, in a step that is taken back."""
    space, parts = assembly.space, assembly.parts
    sweeps, start = space.iterations, [(p.position, p.velocity) for p in parts]
    angle, rate = assembly.body.angle, assembly.body.angular_velocity
    space.iterations = max(sweeps, FIRST)
    space.step(step)
    space.iterations = sweeps
    assembly.body.angle, assembly.body.angular_velocity = angle, rate
    for part, (position, velocity) in zip(parts, start, strict=True):
        part.position, part.velocity = position, velocity
