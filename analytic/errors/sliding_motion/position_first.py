"""Position-first steps of a body on three Coulomb points: parts move straight in a step.

Such an engine moves first, then solves velocities so that every joint is closed when its parts have
moved again. A part at s of a body that turns at omega about C is thus required to have the velocity
i omega s + G s, where G closes what the last step has opened by moving straight,

    G = (1 - e^(-i h omega) (1 + i h omega))/h = -h omega^2/2 + O(h^2),

and so has the slip of a support. The slider is required to move to its target. Friction opposes the
slips at the step's end. Left out is that parts away from C have an angular momentum from G,
(h omega)^2/3 of that from omega.

Targets are left Riemann sums of the slider's velocity, which stay half a step behind its position
and leave its velocity exact even where its acceleration jumps inside a step. But they drift at
second order, turn after turn. Where the acceleration jumps at grid times only they need not: then
they are the position less half a step of the velocity. Derived in THEORY.md, section 7.
"""

from __future__ import annotations

import cmath
from functools import lru_cache

import numpy as np

from plumbob.analytic.errors.sliding_motion.plane_steps import Body, columns_of
from plumbob.analytic.errors.smooth_motion.scheme_steps import Parts
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.slider_path import SliderPath
from plumbob.analytic.systems.three_points.friction import Start
from plumbob.analytic.systems.three_points.implicit_friction import Slip

GRID = 1e-6  # of a step: how near to a grid time a switch is taken to be on it


def opened(turn: float) -> complex:
    """Part of an arm by which a straight step through the angle `turn` [rad] misses the circle."""
    return 1.0 - cmath.exp(-1j * turn) * (1.0 + 1j * turn)


def switches_on_grid(path: SliderPath, step: float) -> bool:
    """Whether the slider's acceleration jumps at multiples of `step` [s] alone."""
    steps = path.breakpoints / step
    return bool(np.abs(steps - np.rint(steps)).max() < GRID)


@lru_cache(maxsize=16)
def position_first_trajectory(
    capsule: Capsule, path: SliderPath, start: Start, step: float, steps: int
) -> Array:
    """COLUMNS at the start and after each of `steps` steps of `step` [s], shape (steps + 1, 6), in
    the ground's axes. A joint that is closed in every step is open at the start by what a step
    before it opened."""
    inside, moving, targets = _targets(path, step, steps)
    body = Body.of(capsule)
    speed = complex(*start.velocity)
    omega = start.angular_velocity
    behind = opened(step * omega)
    sliding = speed + (1j * omega + behind / step) * inside + moving
    states: list[Parts] = [(0j, 0.0, inside * (1.0 - behind), speed, omega, sliding)]
    near: Slip = (speed + 1j * omega * body.mass_ratio * inside, omega)
    for target in targets:
        state, near = _advanced(body, states[-1], target, step, near)
        states.append(state)
    return columns_of(states)


def _advanced(
    body: Body, state: Parts, target: complex, step: float, near: Slip
) -> tuple[Parts, Slip]:
    """State (of the slider its place and velocity in the ground's axes), and slip in the body's,
    after a step that is to bring the slider to `target` in the body [m]."""
    z, psi, slider, speed, omega, sliding = state
    z = z + step * speed
    slider = slider + step * sliding
    psi = psi + step * omega
    turned = cmath.exp(1j * psi)
    behind = opened(step * omega) / step
    arm = slider - z
    inside = arm / turned
    closing = turned * (target - inside) / step
    apart = sliding - closing - speed
    turning = body.inertia * omega + body.reduced_mass * (arm.conjugate() * apart).imag
    free = (speed + body.mass_ratio * apart) / turned, turning / body.inertia_with(inside)
    slip = body.after_friction(inside, step, free, near, behind)
    omega = slip[1]
    speed = slip[0] * turned - 1j * omega * body.mass_ratio * arm
    return (z, psi, slider, speed, omega, speed + 1j * omega * arm + closing), slip


def _targets(
    path: SliderPath, step: float, steps: int
) -> tuple[complex, complex, list[complex]]:
    """Place [m] and velocity [m/s] of the slider in the body at the start, and its place there that
    each step's velocity is to lead to; a velocity acts in the step that follows."""
    places, speeds, _ = path.kinematics(step * np.arange(steps + 2, dtype=np.float64))
    targets = places - 0.5 * step * speeds
    if not switches_on_grid(path, step):
        targets[1:] = places[0] + np.cumsum(step * speeds[:-1], axis=0)
    following: list[complex] = (targets[2:] @ np.array([1.0, 1j])).tolist()
    return complex(*places[0]), complex(*speeds[0]), following
