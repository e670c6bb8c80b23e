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
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.slider_path import SliderPath
from plumbob.analytic.systems.three_points.equations import mechanics
from plumbob.analytic.systems.three_points.friction import Start
from plumbob.analytic.systems.three_points.implicit_friction import (
    FrictionProblem,
    Slip,
    after_friction,
)

GRID = 1e-6  # of a step: how near to a grid time a switch is taken to be on it
State = tuple[complex, float, complex, complex, float, complex]
"""Places of C [m], heading [rad], slider [m]; their rates; in the ground's axes."""
Motion = tuple[complex, float, complex, complex]  # of C, of the heading, of the slider; its arm


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
    """x, y of C [m], heading [rad], velocity of C [m/s], angular velocity [rad/s] at the start and
    after each of `steps` steps of `step` [s], shape (steps + 1, 6), in the ground's axes."""
    inside, moving, targets = _targets(path, step, steps)
    body = _Body.of(capsule, step)
    state, omega = _started(start, inside, moving, step), start.angular_velocity
    slip: Slip = (state[3] + 1j * omega * capsule.mass_ratio * inside, omega)
    rows = np.empty((steps + 1, 6))
    for k in range(steps + 1):
        z, psi, _, speed, omega, _ = state
        rows[k] = z.real, z.imag, psi, speed.real, speed.imag, omega
        if k < steps:
            state, slip = _advanced(body, state, targets[k], step, slip)
    return rows


@dataclass(frozen=True, slots=True)
class _Body:
    """The constants of a capsule as plain numbers, of which a step takes many: its supports in body
    axes [m], and each one's friction limit over a step [N s], affine in the slider's place."""

    capsule: Capsule
    supports: tuple[complex, ...]
    limits_by: tuple[tuple[float, ...], ...]

    @classmethod
    def of(cls, capsule: Capsule, step: float) -> _Body:
        """Those of a capsule that takes steps of `step` [s]."""
        equations = mechanics(capsule)
        limits = (step * np.vstack([equations.centre_limits, equations.limit_slopes])).T.tolist()
        return cls(capsule, tuple(equations.supports.tolist()), tuple(map(tuple, limits)))

    def supports_at(
        self, inside: complex, turned: complex, behind: complex
    ) -> tuple[list[complex], list[float], list[complex]]:
        """Places of the supports from C [m], friction limits [N s] with the slider `inside` the
        body [m], and openings that a step closes [m/s], in the ground's axes."""
        ground = [turned * support for support in self.supports]
        limits = [max(c + x * inside.real + y * inside.imag, 0.0) for c, x, y in self.limits_by]
        return ground, limits, [behind * place for place in ground]


def _started(start: Start, inside: complex, moving: complex, step: float) -> State:
    """State at the start, the slider `inside` the body [m] and `moving` there [m/s]: a joint that
    is closed in every step is open then by what a step before it opened."""
    speed, omega = complex(*start.velocity), start.angular_velocity
    behind = opened(step * omega)
    sliding = speed + (1j * omega + behind / step) * inside + moving
    return 0j, 0.0, inside * (1.0 - behind), speed, omega, sliding


def _advanced(
    body: _Body, state: State, target: complex, step: float, near: Slip
) -> tuple[State, Slip]:
    """State and slip after a step that is to bring the slider to `target` in the body [m]."""
    z, psi, slider, speed, omega, sliding = state
    z, slider, psi = z + step * speed, slider + step * sliding, psi + step * omega
    turned, behind = cmath.exp(1j * psi), opened(step * omega) / step
    arm = slider - z
    inside = arm / turned
    closing = turned * (target - inside) / step
    motion = (speed, omega, sliding - closing, arm)
    supports = body.supports_at(inside, turned, behind)
    slip, centre = _solved(body.capsule, motion, *supports, near)
    omega = slip[1]
    speed = slip[0] - 1j * omega * centre
    return (z, psi, slider, speed, omega, speed + 1j * omega * arm + closing), slip


def _targets(path: SliderPath, step: float, steps: int) -> tuple[complex, complex, list[complex]]:
    """Place [m] and velocity [m/s] of the slider in the body at the start, and its place there that
    each step's velocity is to lead to; a velocity acts in the step that follows."""
    places, speeds, _ = path.kinematics(step * np.arange(steps + 2, dtype=np.float64))
    targets = places - 0.5 * step * speeds
    if not switches_on_grid(path, step):
        targets[1:] = places[0] + np.cumsum(step * speeds[:-1], axis=0)
    following: list[complex] = (targets[2:] @ np.array([1.0, 1j])).tolist()
    return complex(*places[0]), complex(*speeds[0]), following


def _solved(
    capsule: Capsule,
    motion: Motion,
    supports: list[complex],
    limits: list[float],
    offsets: list[complex],
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
    return after_friction(FrictionProblem(mass, inertia, limits, arms, offsets), free, near), centre
