"""Random capsules, slider paths and starts for the three-point motion, by seed; one that coasts."""

import math
from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.systems.capsule import Capsule, validity
from plumbob.analytic.systems.slider_path import (
    SliderPath,
    arc,
    arc_stroke,
    concatenate,
    fixed,
    line_stroke,
    straight,
)
from plumbob.analytic.systems.three_points.friction import InitialVelocities, three_point_motion
from plumbob.tests.support.random_capsules import CHECK


@dataclass(frozen=True)
class Slide:
    """A capsule, its slider's path and the body's start."""

    capsule: Capsule
    path: SliderPath
    start: InitialVelocities

    def motion(self):
        """The exact motion."""
        return three_point_motion(self.capsule, self.path, self.start)

    @property
    def state(self):
        """The start as (x, y, psi, v_x, v_y, omega), shape (6,)."""
        return np.array([0.0, 0.0, 0.0, *self.start.velocity, self.start.angular_velocity])


def _capsule(rng):
    """Any triangle about C, m/M from 0.05 to 6; J is small in every second one, which makes the
    mobility of a support strongly anisotropic."""
    while True:
        angles = np.sort(rng.uniform(0.0, 2 * math.pi, 3))
        arms = rng.uniform(0.05, 0.25, 3)
        a, b, c = (
            (float(r * math.cos(p)), float(r * math.sin(p)))
            for r, p in zip(arms, angles, strict=True)
        )
        body = float(10.0 ** rng.uniform(-0.5, 0.5))
        slider = body * float(10.0 ** rng.uniform(-1.3, 0.8))
        slim = float(10.0 ** rng.uniform(-2.0, 0.0)) if rng.random() < 0.5 else 1.0
        inertia = body * float(rng.uniform(0.3, 1.2) * np.mean(arms**2)) * slim
        try:
            capsule = Capsule(
                body, slider, inertia, (a, b, c), float(rng.uniform(0.1, 0.6)), 9.81
            )
        except ParameterError:
            continue
        if not validity(capsule, fixed((0.0, 0.0)).track()):
            return capsule


def _pieces(rng, scale):
    """Accelerations of either sign, 0.5 to 4 of `scale`, that end at rest, and their durations."""
    count = int(rng.integers(2, 5))
    accelerations = scale * rng.uniform(0.5, 4.0, count) * rng.choice([-1.0, 1.0], count)
    durations = rng.uniform(0.01, 0.06, count)
    accelerations[-1] = -float(accelerations[:-1] @ durations[:-1]) / durations[-1]
    return accelerations.tolist(), durations.tolist()


def _path(rng, capsule):
    hold = capsule.holding_acceleration
    angle = float(rng.uniform(0.0, 2 * math.pi))
    radius = float(rng.uniform(0.02, 0.12))
    kind = int(rng.integers(3))
    if kind == 0:
        place = (float(rng.uniform(-0.05, 0.05)), float(rng.uniform(-0.05, 0.05)))
        return straight(place, angle, *_pieces(rng, hold))
    if kind == 1:
        return arc(radius, angle, *_pieces(rng, hold / radius))
    drive = hold / radius * float(rng.uniform(0.5, 5.0) * rng.choice([-1.0, 1.0]))
    turn = arc_stroke(radius, angle, drive, float(rng.uniform(0.01, 0.05)))
    w1 = hold * float(rng.uniform(0.8, 4.0))
    w2 = hold * float(rng.uniform(0.3, 2.0))
    t1 = math.sqrt(2 * w2 * radius / (w1 * (w1 + w2)))
    inward = math.atan2(-turn.end[1], -turn.end[0])
    back = line_stroke(turn.end, inward, w1, w2, t1)
    return concatenate(turn, fixed(turn.end, float(rng.uniform(0.001, 0.3))), back)


def slide(seed):
    """A slide of one to seven pieces near the friction limit, from rest or, three times in ten,
    from any velocity."""
    rng = np.random.default_rng(seed)
    while True:
        capsule = _capsule(rng)
        path = _path(rng, capsule)
        if not validity(capsule, path.track()):
            break
    if rng.random() < 0.7:
        return Slide(capsule, path, InitialVelocities())
    vx, vy = (float(v) for v in rng.uniform(-0.5, 0.5, 2))
    turn = np.exp(-1j * rng.uniform(-3.0, 3.0))  # to the body's axes
    velocity = complex(vx, vy) * turn
    start = InitialVelocities((velocity.real, velocity.imag), float(rng.uniform(-6, 6)))
    return Slide(capsule, path, start)


def moved_support(capsule, fraction):
    """`capsule` with its first support moved outward by `fraction` of its arm."""
    (x, y), second, third = capsule.supports
    return replace(capsule, supports=((x * (1 + fraction), y * (1 + fraction)), second, third))


# The coasting check body.
COAST = Slide(
    CHECK, fixed((0.12, 0.0)), InitialVelocities(velocity=(0.4, 0.2), angular_velocity=6.0)
)


def pose(motion, time):
    """(x, y, psi) at `time` [s], shape (3,)."""
    at = motion.at(np.array([time]))
    return np.array([*at.position[0], at.heading[0]])


def ending(motion):
    """A time [s] after the final rest."""
    return 1.01 * motion.rest_time + 1e-6
