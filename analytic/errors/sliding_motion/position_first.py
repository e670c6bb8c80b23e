"""Position-first steps of a body on three Coulomb points: parts move along straight lines.

Such an engine moves first. Then it solves for velocities that close every joint when the parts have
moved again. A part at the position s of a body that turns at omega about C is therefore required to
have the velocity i omega s + G s. G closes the opening that the last straight step has left:

    G = (1 - e^(-i h omega) (1 + i h omega))/h = -h omega^2/2 + O(h^2),

The slip of a support has the same additional part. The slider is required to move to its target.
Friction opposes the slips at the step's end. One effect is left out: parts away from C have an
angular momentum from G, (h omega)^2/3 of their angular momentum from omega.

Targets are left Riemann sums of the slider's velocity. They stay half a step behind the slider's
position, and keep its velocity exact even if its acceleration jumps inside a step. But they drift
at second order, turn after turn. If the acceleration jumps at grid times only, the targets are the
position less half a step of the velocity, which does not drift. Derivation: THEORY.md, section 7.
"""

from __future__ import annotations

import cmath
from functools import lru_cache

import numpy as np

from plumbob.analytic.errors.sliding_motion.plane_steps import Body, columns_of_states
from plumbob.analytic.errors.smooth_motion.scheme_steps import Parts
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.slider_path import SliderPath
from plumbob.analytic.systems.three_points.friction import Start
from plumbob.analytic.systems.three_points.implicit_friction import Slip

GRID = 1e-6  # [steps] a switch closer to a grid time counts as on the grid


def chord_error(turn: float) -> complex:
    """Returns the error of a straight step through the angle `turn` [rad], over the arm."""
    return 1.0 - cmath.exp(-1j * turn) * (1.0 + 1j * turn)


def switches_on_grid(path: SliderPath, step: float) -> bool:
    """Returns whether the slider's acceleration jumps only at multiples of `step` [s]."""
    switch_steps = path.breakpoints / step
    return bool(np.abs(switch_steps - np.rint(switch_steps)).max() < GRID)


@lru_cache(maxsize=16)
def position_first_trajectory(
    capsule: Capsule, path: SliderPath, start: Start, step: float, steps: int
) -> Array:
    """Returns COLUMNS at the start and after each of `steps` steps of `step` [s].

    The result has the shape (steps + 1, 6), in the axes of the ground. At the start, joints are as
    open as an earlier step would have left them.
    """
    place, rate, targets = _targets(path, step, steps)
    body = Body.of(capsule)
    speed = complex(*start.velocity)
    omega = start.angular_velocity
    opening = chord_error(step * omega)
    slider = place * (1.0 - opening)
    slider_velocity = speed + (1j * omega + opening / step) * place + rate
    states: list[Parts] = [(0j, 0.0, slider, speed, omega, slider_velocity)]
    near: Slip = (speed + 1j * omega * body.mass_ratio * place, omega)
    for target in targets:
        state, near = _next_state(body, states[-1], target, step, near)
        states.append(state)
    return columns_of_states(states)


def _next_state(
    body: Body, state: Parts, target: complex, step: float, near: Slip
) -> tuple[Parts, Slip]:
    """Returns the state and the slip after a step that moves the slider to `target` [m].

    A state is z, psi, the slider's position, z', omega and the slider's velocity, in the axes of
    the ground. The slip is in the axes of the body. `near` is a slip from which the search starts.
    """
    z, psi, slider, speed, omega, slider_velocity = state
    z = z + step * speed
    slider = slider + step * slider_velocity
    psi = psi + step * omega
    turn = cmath.exp(1j * psi)
    arm = slider - z
    place = arm / turn
    closing = turn * (target - place) / step
    mismatch = slider_velocity - closing - speed
    spin = body.inertia * omega + body.reduced_mass * (arm.conjugate() * mismatch).imag
    velocity = (speed + body.mass_ratio * mismatch) / turn
    free_slip = velocity, spin / body.inertia_with(place)
    slip = body.after_friction(place, step, free_slip, near, chord_error(step * omega) / step)
    velocity, omega = slip
    speed = velocity * turn - 1j * omega * body.mass_ratio * arm
    slider_velocity = speed + 1j * omega * arm + closing
    return (z, psi, slider, speed, omega, slider_velocity), slip


def _targets(
    path: SliderPath, step: float, steps: int
) -> tuple[complex, complex, list[complex]]:
    """Returns the slider's first position [m], first velocity [m/s] and targets [m] in the body.

    Each target is the position that the velocity of one step has to lead to. A velocity acts in the
    step after the one in which it is solved for.
    """
    places, speeds, _ = path.kinematics(step * np.arange(steps + 2, dtype=np.float64))
    targets = places - 0.5 * step * speeds
    if not switches_on_grid(path, step):
        targets[1:] = places[0] + np.cumsum(step * speeds[:-1], axis=0)
    complex_targets: list[complex] = (targets[2:] @ np.array([1.0, 1j])).tolist()
    return complex(*places[0]), complex(*speeds[0]), complex_targets
