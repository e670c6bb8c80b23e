"""Coulomb points at rest: whether friction holds them, and how they start when it does not.

With every support at rest, Gauss' principle gives the acceleration a = (x, y, angle) of the body as
the minimum of a convex function,

    (1/2) a.Ma - a.n + sum f N_i |G_i a|,      G_i a: acceleration of support i,

n being the wrench that moves the body. The minimum is 0 (rest), a rotation about one support
(pivot) or leaves no support at rest (slide): one problem decides mode and direction together. Rest
holds when a.n <= sum f N_i |G_i a| for every a: n then lies in the sum of the friction discs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.three_points.equations import Complex, Configuration, Mechanics, cross

NEWTON_STEPS = 80
EDGE = 1e-12  # a wrench this near the edge of the set, relatively, counts as held


@dataclass(frozen=True)
class Onset:
    """How a body at rest starts to move: linear acceleration of the body's point at G (complex
    [m/s^2], body axes) and angular acceleration [rad/s^2]; `support` is the one it pivots about."""

    mode: Literal["rest", "pivot", "slide"]
    support: int = -1
    linear: complex = 0j
    angular: float = 0.0


def lowest(
    quadratic: Array, linear: Array, limits: Array, maps: Complex, offsets: Complex, start: Array
) -> Array:
    """Minimum over y of y.Py/2 - b.y + sum c_i |G_i y + g_i|, by Newton's method with halving.

    P (d, d), b (d,), c (k,); G (k, d) and g (k,) are plane vectors. `start` lies below every place
    where a norm vanishes, so that no step ever meets one.
    """
    y = start
    for _ in range(NEWTON_STEPS):
        vectors = maps @ y + offsets
        norms = np.abs(vectors)
        e = (vectors / norms)[:, None]
        height = float(0.5 * y @ quadratic @ y - linear @ y + limits @ norms)
        gradient = quadratic @ y - linear + limits @ (e.conjugate() * maps).real
        across = cross(e, maps)
        step = -np.linalg.solve(quadratic + (across.T * (limits / norms)) @ across, gradient)
        slope = float(gradient @ step)
        if -slope <= 1e-15 * (abs(height) + float(limits @ norms)):
            # Newton's step gains less than rounding can show: take it, for it squares the error.
            return np.asarray(y + step)
        fraction = 1.0
        while fraction > 1e-12:
            there = y + fraction * step
            level = 0.5 * there @ quadratic @ there - linear @ there
            if level + limits @ np.abs(maps @ there + offsets) <= height + 1e-4 * fraction * slope:
                break
            fraction *= 0.5
        y = y + fraction * step
    return y


def _leave(value: Callable[[Array], float], place: Array, direction: Array, size: float) -> Array:
    """A point below `place`, a kink of `value`, along a `direction` of descent."""
    level = value(place)
    while not value(place + size * direction) < level:
        size *= 0.5
        if size < 1e-200:
            return place + 1e-12 * direction
    return place + size * direction


def needed_wrench(
    body: Mechanics, at: Configuration, heading: Array | float
) -> tuple[Complex, Array]:
    """Force [N] and torque about G [N m] that friction must balance for the body to stay at rest,
    shape (n,): the slider's reaction -m w and the slope's pull."""
    pull = body.tilt * np.exp(-1j * np.asarray(heading))
    force = body.mass * (pull - body.mass_ratio * at.acceleration)
    return np.asarray(force), -body.reduced_mass * cross(at.position, at.acceleration)


def simply_held(at: Configuration, force: Complex, torque: Array) -> npt.NDArray[np.bool_]:
    """Whether shares N_i (X + Y k x arm_i) hold the wrench, shape (n,): sufficient in general, and
    exact for a force through G, where all shares have one direction."""
    spread = (at.limits * np.abs(at.arms) ** 2).sum(axis=1)
    shares = (force / at.limits.sum(axis=1))[:, None] + 1j * at.arms * (torque / spread)[:, None]
    return np.asarray(np.abs(shares).max(axis=1) <= 1.0 + EDGE)


def _velocity_maps(arms: Complex) -> Complex:
    return np.stack([np.ones(3), 1j * np.ones(3), 1j * arms], axis=1)


def load_factor(limits: Array, arms: Complex, force: complex, torque: float) -> tuple[float, Array]:
    """Gauge of a wrench in the set that the friction discs can give, held when 1 or less, and the
    velocity (x, y, angle), shape (3,), that it would set in motion.

    Largest of (wrench . q)/sum f N_i |v_i(q)| over velocities q; `limits` f N_i [N] and `arms` from
    G [m], shape (3,); `force` [N] and `torque` [N m] about G.
    """
    length = float(np.sqrt(np.mean(np.abs(arms) ** 2)))
    wrench = np.array([force.real, force.imag, torque / length])
    size = float(np.linalg.norm(wrench))
    if size == 0.0:
        return 0.0, np.zeros(3)
    if not limits.any():
        return np.inf, wrench / [1.0, 1.0, length]
    # On the plane wrench . q = size the dissipation is convex, with a kink at each pivot.
    normal = wrench / size
    maps = _velocity_maps(arms / length)
    basis = np.linalg.svd(normal[None, :])[2][1:].T
    flat, offsets = maps @ basis, maps @ normal

    def dissipation(y: Array) -> float:
        return float(limits @ np.abs(flat @ y + offsets))

    start, kink = np.zeros(2), -1
    for i in range(3):
        square = np.stack([flat[i].real, flat[i].imag])
        if abs(np.linalg.det(square)) > 1e-12:
            place = -np.linalg.solve(square, [offsets[i].real, offsets[i].imag])
            if dissipation(place) <= dissipation(start):
                start, kink = place, i
    y = start
    if kink >= 0:
        others = [i for i in range(3) if i != kink]
        e = flat[others] @ start + offsets[others]
        gradient = limits[others] @ ((e / np.abs(e)).conjugate()[:, None] * flat[others]).real
        square = np.stack([flat[kink].real, flat[kink].imag])
        share = -np.linalg.solve(square.T, gradient)
        if np.linalg.norm(share) > limits[kink]:
            direction = np.linalg.solve(square, share / np.linalg.norm(share))
            y = _leave(dissipation, start, direction, 1.0 + float(np.linalg.norm(start)))
            kink = -1
    if kink < 0:
        y = lowest(np.zeros((2, 2)), np.zeros(2), limits, flat, offsets, y)
    q = normal + basis @ y
    return size / dissipation(y), q / [1.0, 1.0, length]


def onset(
    mass: float, inertia: float, limits: Array, arms: Complex, force: complex, torque: float
) -> Onset:
    """How a body at rest answers a wrench about G: `mass` M + m [kg], `inertia` J + mu M r^2
    [kg m^2], `limits` f N_i [N] and `arms` from G [m], shape (3,), `force` [N], `torque` [N m]."""
    factor, worst = load_factor(limits, arms, force, torque)
    if factor <= 1.0 + EDGE:
        return Onset("rest")
    maps, masses = _velocity_maps(arms), np.diag([mass, mass, inertia])
    wrench = np.array([force.real, force.imag, torque])

    def constraint(a: Array) -> float:
        return float(0.5 * a @ masses @ a - wrench @ a + limits @ np.abs(maps @ a))

    gain = float(wrench @ worst - limits @ np.abs(maps @ worst))
    start = worst * gain / float(worst @ masses @ worst)
    for i in range(3):
        about = np.array([arms[i].imag, -arms[i].real, 1.0])  # rotates about support i
        turning, resisting = float(wrench @ about), float(limits @ np.abs(maps @ about))
        rate = np.sign(turning) * max(abs(turning) - resisting, 0.0) / float(about @ masses @ about)
        if rate == 0.0:
            continue
        a = rate * about
        moving = maps @ a
        moving[i] = 0.0
        forces = -limits * moving / np.where(moving == 0.0, 1.0, np.abs(moving))
        share = mass * complex(a[0], a[1]) - force - complex(forces.sum())
        if abs(share) <= limits[i] * (1.0 + EDGE):
            return Onset("pivot", i, complex(a[0], a[1]), rate)
        if constraint(a) <= constraint(start) * (1.0 - 1e-9):  # both are negative
            # Not held at i: below this pivot is where the support slips against the share it lacks.
            slip = -np.array([share.real, share.imag, 0.0]) / abs(share)
            start = _leave(constraint, a, slip, float(np.linalg.norm(a)))
    a = lowest(masses, wrench, limits, maps, np.zeros(3, dtype=np.complex128), start)
    return Onset("slide", -1, complex(a[0], a[1]), float(a[2]))


def slip_onset(mass: float, inertia: float, limit: float, arm: complex, share: complex) -> complex:
    """Acceleration [m/s^2] with which a support at rest slips when it needs the force `share` [N]
    and its `limit` f N [N] is smaller, the rest of the body moving on."""
    lever = np.array([-arm.imag, arm.real])
    mobility = np.eye(2) / mass + np.outer(lever, lever) / inertia
    linear = -np.array([share.real, share.imag])
    size = float(np.linalg.norm(linear))
    quadratic: Array = np.asarray(np.linalg.inv(mobility))
    unit = linear / size
    start = unit * (size - limit) / float(unit @ quadratic @ unit)
    maps = np.array([[1.0, 1j]])
    a = lowest(quadratic, linear, np.array([limit]), maps, np.zeros(1, dtype=np.complex128), start)
    return complex(a[0], a[1])
