"""Independent check of the three-point motion: smoothed friction, stiff integration, extrapolation.

Coulomb's v/|v| becomes v/sqrt(v^2 + delta^2), the equations are Newton's (Chernousko 2020, eqs.
2-4) in ground axes with the slider's acceleration, and Radau integrates them without knowing of any
event. The error is C delta + O(delta^2 log delta), most of it drift of the regularised stiction:
two deltas eliminate the first term. The error is larger where a load grows through the friction
limit (delta^(4/5): v ~ t^2 and dv/dt ~ delta^2/v^2 there), and where a support passes rest at a
speed of the order of delta. Only the slider's path is common with the event-driven motion.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.slider_path import SliderPath

RELATIVE, ABSOLUTE = 1e-9, 1e-13
TINY = 1e-30  # complex step of a derivative, free of cancellation

Kinematics = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
Slider = Callable[[float], Kinematics]
Rates = Callable[[Any, Kinematics], list[Any]]


@dataclass(frozen=True)
class SmoothedPose:
    """Extrapolated pose (x [m], y [m], psi [rad]), shape (3,), and by how much the extrapolation
    moved it."""

    pose: Array
    moved: Array


def _rates(capsule: Capsule, delta: float) -> Rates:
    """d/dt of (x, y, psi, v_x, v_y, omega), of floats or, for a derivative, of complex numbers."""
    m, mass = capsule.slider_mass, capsule.body_mass + capsule.slider_mass
    mu, supports = m / mass, capsule.supports
    # Loads from the balance of forces and of moments about C: affine in r.
    balance = np.linalg.inv(np.vstack([np.ones(3), np.transpose(supports)]))
    weights = capsule.friction * capsule.gravity * balance @ np.diag([mass, m, m])
    slopes: list[list[float]] = weights.tolist()

    def rates(state: Any, slider: Kinematics) -> list[Any]:
        heading, speed_x, speed_y, omega = state[2:]
        c, s = math.cos(heading.real), math.sin(heading.real)
        if heading.imag:
            c, s = c - 1j * heading.imag * s, s + 1j * heading.imag * c
        r, v, w = slider
        rx, ry = c * r[0] - s * r[1], s * r[0] + c * r[1]
        vx, vy = c * v[0] - s * v[1], s * v[0] + c * v[1]
        # Slider's acceleration but for dv_C/dt and d omega/dt: centripetal, Coriolis, relative.
        bx = c * w[0] - s * w[1] - omega * (omega * rx + 2.0 * vy)
        by = s * w[0] + c * w[1] - omega * (omega * ry - 2.0 * vx)
        fx = fy = moment = 0.0
        for (ax, ay), (constant, by_x, by_y) in zip(supports, slopes, strict=True):
            px, py = c * ax - s * ay, s * ax + c * ay
            ux, uy = speed_x - omega * py, speed_y + omega * px
            load = constant + by_x * r[0] + by_y * r[1]
            friction = -load / (ux * ux + uy * uy + delta * delta) ** 0.5
            fx, fy = fx + friction * ux, fy + friction * uy
            moment = moment + friction * (px * uy - py * ux)
        # (M + m) a + m alpha k x r = sum F - m b;  J alpha + m r x (a + alpha k x r + b) = moment.
        gx, gy = fx / mass - mu * bx, fy / mass - mu * by
        inertia = capsule.inertia + m * (1.0 - mu) * (rx * rx + ry * ry)
        alpha = (moment - m * (rx * (gy + by) - ry * (gx + bx))) / inertia
        return [speed_x, speed_y, omega, gx + mu * alpha * ry, gy - mu * alpha * rx, alpha]

    return rates


def _derivative(rates: Rates, state: list[float], slider: Kinematics) -> Array:
    columns = np.zeros((6, 6))
    for k in range(2, 6):
        shifted: list[complex] = list(state)
        shifted[k] = shifted[k] + TINY * 1j
        columns[:, k] = [value.imag / TINY for value in rates(shifted, slider)]
    return columns


def smoothed_motion(
    capsule: Capsule, path: SliderPath, start: Array, duration: float, delta: float
) -> Array:
    """Pose and velocity (x, y, psi, v_x, v_y, omega), shape (6,), at `duration` [s] from `start`,
    shape (6,), with friction smoothed over `delta` [m/s]. Raises RuntimeError if Radau fails."""
    from scipy.integrate import solve_ivp

    state, rates = np.asarray(start, dtype=np.float64), _rates(capsule, delta)
    begins = [0.0, *(float(t) for t in path.breakpoints[1:] if t < duration)]
    for number, (begin, end) in enumerate(zip(begins, [*begins[1:], duration], strict=True)):
        if end <= begin:
            continue

        @lru_cache(maxsize=16)  # Newton's iterations use the same few times repeatedly
        def slider(t: float, begin: float = begin, number: int = number) -> Kinematics:
            if number == len(path.pieces):
                return path.end, (0.0, 0.0), (0.0, 0.0)
            r, v, w = path.pieces[number].kinematics(np.array([t - begin]))
            return tuple(r[0].tolist()), tuple(v[0].tolist()), tuple(w[0].tolist())

        def slope(t: float, y: Array, slider: Slider = slider) -> list[float]:
            return rates(y.tolist(), slider(t))

        def jacobian(t: float, y: Array, slider: Slider = slider) -> Array:
            return _derivative(rates, y.tolist(), slider(t))

        solution = solve_ivp(
            *(slope, (begin, end), state),
            method="Radau",
            rtol=RELATIVE,
            atol=ABSOLUTE,
            jac=jacobian,
        )
        if not solution.success:
            raise RuntimeError(solution.message)
        state = solution.y[:, -1]
    return np.asarray(state)


def smoothed_pose(
    capsule: Capsule,
    path: SliderPath,
    start: Array,
    duration: float,
    delta: float = 1e-8,
    order: float = 1.0,
) -> SmoothedPose:
    """Pose at `duration` [s] from `start` (x, y, psi, v_x, v_y, omega), extrapolated to delta -> 0
    from `delta` [m/s] and half of it, the error going as delta^`order`: 1, or 4/5 where a
    load grows through the friction limit."""
    coarse, fine = (
        smoothed_motion(capsule, path, start, duration, width)[:3] for width in (delta, 0.5 * delta)
    )
    moved = (fine - coarse) / (1.0 - 0.5**order)
    return SmoothedPose(coarse + moved, moved)
