"""What position-first steps make of a body on three Coulomb points: its parts go along chords.

Engines in the manner of Chipmunk move first, then solve velocities so that every joint is closed
when its parts have moved again. What turns at omega about C is thus asked for the velocity
i omega s + G s at s, where G closes what the last step has opened by going straight,

    G = (1 - e^(-i h omega) (1 + i h omega))/h = -h omega^2/2 + O(h^2),

and so is the slip of a support. The slider is asked for what brings it to its aim. Friction opposes
the slips that the step ends with. Left out is that parts which stand apart have a moment from G,
(h omega)^2/3 of that from omega.

Aims are left sums of the slider's velocity, which keep half a step behind its place and leave its
velocity exact even where its acceleration jumps inside a step. But they drift by the second order,
turn after turn. Where it jumps on the grid alone they need not: then they are its place less half a
step of its velocity.
"""

from __future__ import annotations

import cmath
from functools import lru_cache

import numpy as np

from plumbob.analytic.errors.discontinuities import GRID
from plumbob.analytic.errors.implicit_friction import FrictionProblem, Slip, after_friction
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.slider_path import SliderPath
from plumbob.analytic.systems.three_points.equations import mechanics
from plumbob.analytic.systems.three_points.friction import Start

Motion = tuple[complex, float, complex, complex]  # of C, of the heading, of the slider; its arm


def opened(turn: float) -> complex:
    """What of an arm a straight step through the angle `turn` [rad] leaves behind the circle."""
    return 1.0 - cmath.exp(-1j * turn) * (1.0 + 1j * turn)


def switches_on_grid(path: SliderPath, step: float) -> bool:
    """Whether the slider's acceleration jumps at multiples of `step` [s] alone."""
    steps = path.breakpoints / step
    return bool(np.abs(steps - np.rint(steps)).max() < GRID)


@lru_cache(maxsize=16)
def position_first_course(
    capsule: Capsule, path: SliderPath, start: Start, step: float, steps: int
) -> Array:
    """x, y of C [m], heading [rad], velocity of C [m/s], angular velocity [rad/s] at the start and
    after each of `steps` steps of `step` [s], shape (steps + 1, 6), in the ground's axes."""
    places, speeds, _ = path.kinematics(step * np.arange(steps + 2, dtype=np.float64))
    inside, moving = complex(*places[0]), complex(*speeds[0])
    aimed = places - 0.5 * step * speeds
    if not switches_on_grid(path, step):
        aimed[1:] = places[0] + np.cumsum(step * speeds[:-1], axis=0)
    # A velocity is at work in the step that follows.
    aims = (aimed[2:] @ np.array([1.0, 1j])).tolist()
    given = mechanics(capsule)
    supports: list[complex] = given.supports.tolist()
    most = (step * np.vstack([given.centre_limits, given.limit_slopes])).T.tolist()
    z, psi, omega = complex(*start.position), start.heading, start.angular_velocity
    speed, turned = complex(*start.velocity), cmath.exp(1j * psi)
    slip: Slip = (speed + 1j * omega * given.mass_ratio * turned * inside, omega)
    # A joint that is closed in every step is open at the start by what a step before it opened.
    behind = opened(step * omega)
    slider = z + turned * inside * (1.0 - behind)
    sliding = speed + turned * ((1j * omega + behind / step) * inside + moving)
    rows = np.empty((steps + 1, 6))
    rows[0] = z.real, z.imag, psi, speed.real, speed.imag, omega
    for k, aim in enumerate(aims):
        z, slider, psi = z + step * speed, slider + step * sliding, psi + step * omega
        turned, behind = cmath.exp(1j * psi), opened(step * omega) / step
        arm = slider - z
        inside = arm / turned
        closing = turned * (aim - inside) / step
        ground = [turned * support for support in supports]
        limits = [max(c + x * inside.real + y * inside.imag, 0.0) for c, x, y in most]
        chords = [behind * place for place in ground]
        motion = (speed, omega, sliding - closing, arm)
        slip, centre = _solved(capsule, motion, ground, limits, chords, slip)
        omega = slip[1]
        speed = slip[0] - 1j * omega * centre
        sliding = speed + 1j * omega * arm + closing
        rows[k + 1] = z.real, z.imag, psi, speed.real, speed.imag, omega
    return rows


def _solved(
    capsule: Capsule,
    motion: Motion,
    supports: list[complex],
    limits: list[float],
    chords: list[complex],
    near: Slip,
) -> tuple[Slip, complex]:
    """Velocity of the combined centre and rate after a step, and where that is from C [m]."""
    (speed, omega, sliding, arm), m = motion, capsule.slider_mass
    mass = capsule.body_mass + m
    centre = m / mass * arm
    momentum = capsule.body_mass * speed + m * sliding
    inertia = capsule.inertia + m * abs(arm) ** 2 - mass * abs(centre) ** 2
    turning = capsule.inertia * omega + m * (arm.conjugate() * sliding).imag
    spin = (turning - (centre.conjugate() * momentum).imag) / inertia
    free = (momentum / mass, spin)
    if not any(limits):
        return free, centre
    arms = [support - centre for support in supports]
    return after_friction(FrictionProblem(mass, inertia, limits, arms, chords), free, near), centre
