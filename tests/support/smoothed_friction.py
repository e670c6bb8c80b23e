"""Independent check of the three-point motion: smoothed friction, stiff integration, extrapolation.

Coulomb's v/|v| becomes v/sqrt(v^2 + delta^2), the equations are Newton's (Chernousko 2020, eqs.
2-4) in ground axes with the slider's acceleration, and Radau integrates them without knowing of any
event. The error is C delta + O(delta^2 log delta), most of it drift of the regularised stiction:
two deltas eliminate the first term. The error is larger where a load grows through the friction
limit (delta^(4/5): v ~ t^2 and dv/dt ~ delta^2/v^2 there), and where a support passes rest at a
speed of the order of delta. Nothing is common with the event-driven motion but the numbers of the
slider's path.
"""

import itertools
import math
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np

from plumbob.analytic.reference import Array

RELATIVE, ABSOLUTE = 1e-9, 1e-13
TINY = 1e-30  # complex step of a derivative, free of cancellation


@dataclass(frozen=True)
class SmoothedPose:
    """Extrapolated pose (x [m], y [m], psi [rad]), shape (3,), by how much the extrapolation moved
    it, and its rates."""

    pose: Array
    moved: Array
    rates: Array


def _rates(capsule, delta):
    """d/dt of (x, y, psi, v_x, v_y, omega), of floats or, for a derivative, of complex numbers."""
    m = capsule.slider_mass
    mu = m / (capsule.body_mass + m)
    drag = partial(_friction, capsule.supports, _limits(capsule), delta)

    def rates(state, slider):
        axes = _axes(state[2])
        (rx, ry), (bx, by) = _carried(axes, state[5], slider)
        fx, fy, moment = drag(axes, state[3:], slider[0])
        # (M + m) a + m alpha k x r = sum F - m b;  J alpha + m r x (a + alpha k x r + b) = moment.
        gx = fx / (capsule.body_mass + m) - mu * bx
        gy = fy / (capsule.body_mass + m) - mu * by
        inertia = capsule.inertia + m * (1.0 - mu) * (rx * rx + ry * ry)
        alpha = (moment - m * (rx * (gy + by) - ry * (gx + bx))) / inertia
        return [*state[3:], gx + mu * alpha * ry, gy - mu * alpha * rx, alpha]

    return rates


def _limits(capsule):
    """Friction limits from the balance of forces and of moments about C, affine in r: a row each,
    at C and by x and y."""
    mass = capsule.body_mass + capsule.slider_mass
    balance = np.linalg.inv(np.vstack([np.ones(3), np.transpose(capsule.supports)]))
    weights = np.diag([mass, capsule.slider_mass, capsule.slider_mass])
    limits = (capsule.friction * capsule.gravity * balance @ weights).tolist()
    return limits


def _axes(heading):
    """Cosine and sine of a heading; its imaginary part is small."""
    c = math.cos(heading.real)
    s = math.sin(heading.real)
    if heading.imag:
        return c - 1j * heading.imag * s, s + 1j * heading.imag * c
    return c, s


def _turned(axes, vector):
    """A vector of the body, in the ground's axes."""
    (c, s), (x, y) = axes, vector
    return c * x - s * y, s * x + c * y


def _carried(axes, omega, slider):
    """Slider's place from C, and its acceleration but for dv_C/dt and d omega/dt: centripetal,
    Coriolis, relative."""
    (rx, ry), (vx, vy), (wx, wy) = (_turned(axes, vector) for vector in slider)
    bx = wx - omega * (omega * rx + 2.0 * vy)
    by = wy - omega * (omega * ry - 2.0 * vx)
    return (rx, ry), (bx, by)


def _friction(supports, limits, delta, axes, velocity, place):
    """Smoothed friction and its moment about C, with the slider at `place` in the body."""
    speed_x, speed_y, omega = velocity
    fx = fy = moment = 0.0
    for support, limit in zip(supports, limits, strict=True):
        px, py = _turned(axes, support)
        ux = speed_x - omega * py
        uy = speed_y + omega * px
        load = limit[0] + limit[1] * place[0] + limit[2] * place[1]
        friction = -load / (ux * ux + uy * uy + delta * delta) ** 0.5
        fx = fx + friction * ux
        fy = fy + friction * uy
        moment = moment + friction * (px * uy - py * ux)
    return fx, fy, moment


def _derivative(rates, state, slider):
    columns = np.zeros((6, 6))
    for k in range(2, 6):
        shifted = list(state)
        shifted[k] = shifted[k] + TINY * 1j
        columns[:, k] = [value.imag / TINY for value in rates(shifted, slider)]
    return columns


def followed(piece, time):
    """Place [m], velocity [m/s] and acceleration [m/s^2] of the slider in the body at a `time` [s]
    of a piece of its path, two numbers each: on a circle about C, or along a line."""
    rate, w = getattr(piece, "rate", None), piece.acceleration
    if rate is not None:
        angle = piece.angle + rate * time + w * time**2 / 2
        rate = rate + w * time
        x, y = (piece.radius * f(angle) for f in (math.cos, math.sin))
        return (x, y), (-rate * y, rate * x), (-w * y - rate**2 * x, w * x - rate**2 * y)
    shift = piece.position + piece.speed * time + w * time**2 / 2
    speed = piece.speed + w * time
    unit = math.cos(piece.direction), math.sin(piece.direction)
    place = tuple(
        begin + shift * along for begin, along in zip(piece.origin, unit, strict=True)
    )
    return place, tuple(speed * along for along in unit), tuple(w * along for along in unit)


def smoothed_motion(capsule, path, start, duration, delta):
    """Pose and velocity (x, y, psi, v_x, v_y, omega), shape (6,), at `duration` [s] from `start`,
    shape (6,), with friction smoothed over `delta` [m/s]. Raises RuntimeError if Radau fails."""
    from scipy.integrate import solve_ivp

    state = np.asarray(start, dtype=np.float64)
    rates = _rates(capsule, delta)
    ends = [*itertools.accumulate(piece.duration for piece in path.pieces)]
    begins = [0.0, *(t for t in ends if t < duration)]
    last = path.pieces[-1]
    stopped = followed(last, last.duration)[0]
    for number, (begin, end) in enumerate(zip(begins, [*begins[1:], duration], strict=True)):
        if end <= begin:
            continue

        @lru_cache(maxsize=16)  # Newton's iterations use the same few times repeatedly
        def slider(t, begin=begin, number=number):
            if number == len(path.pieces):
                return stopped, (0.0, 0.0), (0.0, 0.0)
            return followed(path.pieces[number], t - begin)

        def slope(t, y, slider=slider):
            return rates(y.tolist(), slider(t))

        def jacobian(t, y, slider=slider):
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


def smoothed_pose(capsule, path, start, duration, delta=1e-8, order=1.0):
    """Pose and rates at `duration` [s] from `start` (x, y, psi, v_x, v_y, omega), extrapolated to
    delta -> 0 from `delta` [m/s] and half of it, the error going as delta^`order`: 1, or 4/5 where
    a load grows through the friction limit."""
    coarse, fine = (
        smoothed_motion(capsule, path, start, duration, width) for width in (delta, 0.5 * delta)
    )
    moved = (fine - coarse) / (1.0 - 0.5**order)
    state = coarse + moved
    return SmoothedPose(state[:3], moved[:3], state[3:])
