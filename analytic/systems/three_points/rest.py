"""Coulomb points at rest: whether static friction suffices, and until when.

The body sticks when a.n <= sum f N_i |G_i a| for every acceleration a = (x, y, angle) of the body,
G_i a being that of support i and n the wrench that moves the body: n then lies in the sum of the
friction discs. How motion starts, where it does not, is decided in `implicit_friction`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.slider_path import Piece, StraightPiece
from plumbob.analytic.systems.three_points.equations import (
    Complex,
    Configuration,
    Mechanics,
    configuration,
    cross,
    mechanics,
)

NEWTON_STEPS = 80
EDGE = 1e-12  # a wrench this near the friction limit, relatively, counts as within it
SAMPLES = 65  # of a rest, for the first time at which friction does not suffice


def lowest(limits: Array, maps: Complex, offsets: Complex, start: Array) -> Array:
    """Minimum over y of sum c_i |G_i y + g_i|, by Newton's method with halving.

    c (k,), G (k, d) and g (k,), plane vectors. The value at `start` is below that at every point
    where a norm vanishes, so that no step reaches one.
    """
    y = start
    for _ in range(NEWTON_STEPS):
        vectors = maps @ y + offsets
        norms = np.abs(vectors)
        e = (vectors / norms)[:, None]
        height = float(limits @ norms)
        gradient = limits @ (e.conjugate() * maps).real
        across = cross(e, maps)
        step = -np.linalg.solve((across.T * (limits / norms)) @ across, gradient)
        slope = float(gradient @ step)
        if -slope <= 2e-15 * height:
            # The gain is below round-off; the step is still taken, since it squares the error.
            return y + step
        fraction = 1.0
        while fraction > 1e-12:
            trial = maps @ (y + fraction * step) + offsets
            if limits @ np.abs(trial) <= height + 1e-4 * fraction * slope:
                break
            fraction *= 0.5
        y = y + fraction * step
    return y


def _leave(value: Callable[[Array], float], place: Array, direction: Array, size: float) -> Array:
    """A point where `value` is less than at `place`, where it is not smooth, along a `direction` of
    descent."""
    level = value(place)
    while not value(place + size * direction) < level:
        size *= 0.5
        if size < 1e-200:
            return place + 1e-12 * direction
    return place + size * direction


def needed_wrench(body: Mechanics, at: Configuration) -> tuple[Complex, Array]:
    """Force [N] and torque about G [N m] that friction must balance for the body to stay at rest,
    shape (n,): the slider's reaction -m w."""
    force = -body.mass * body.mass_ratio * at.acceleration
    return np.asarray(force), -body.reduced_mass * cross(at.position, at.acceleration)


def simply_held(at: Configuration, force: Complex, torque: Array) -> npt.NDArray[np.bool_]:
    """Whether support forces N_i (X + Y k x arm_i) balance the wrench within the friction limits,
    shape (n,): sufficient in general, and exact for a force through G, where all are parallel."""
    spread = (at.limits * np.abs(at.arms) ** 2).sum(axis=1)
    ratios = (force / at.limits.sum(axis=1))[:, None] + 1j * at.arms * (torque / spread)[:, None]
    return np.asarray(np.abs(ratios).max(axis=1) <= 1.0 + EDGE)


def _velocity_maps(arms: Complex) -> Complex:
    return np.stack([np.ones(3), 1j * np.ones(3), 1j * arms], axis=1)


@dataclass(frozen=True)
class _Dissipation:
    """sum f N_i |v_i(q)| on the plane wrench . q = |wrench|, q = normal + basis y: convex in y, and
    not smooth at each pivot; `flat` (3, 2) and `offsets` (3,) map y to v_i."""

    limits: Array
    flat: Complex
    offsets: Complex

    def value(self, y: Array) -> float:
        return float(self.limits @ np.abs(self.flat @ y + self.offsets))

    def _places(self) -> tuple[Array, Array]:
        """The y of each pivot, shape (3, 2), by Cramer's rule, and the determinants of the maps of
        y to v_i, shape (3,)."""
        first, second = self.flat.T
        sizes = cross(first, second)
        with np.errstate(divide="ignore", invalid="ignore"):
            places = np.stack([cross(second, self.offsets), cross(self.offsets, first)]) / sizes
        return places.T, sizes

    def lowest_corner(self) -> tuple[Array, int]:
        """The lowest of y = 0 and the pivots, and the support of the pivot, else -1."""
        places, sizes = self._places()
        start, corner = np.zeros(2), -1
        least = self.value(start)
        for i in range(3):
            if abs(sizes[i]) > 1e-12 and (value := self.value(places[i])) <= least:
                start, corner, least = places[i], i, value
        return start, corner

    def descent(self, place: Array, corner: int) -> Array | None:
        """A direction of descent from the pivot at `place`; None where it is the minimum, the
        support needing no more than its friction limit."""
        others = [i for i in range(3) if i != corner]
        e = self.flat[others] @ place + self.offsets[others]
        unit = (e / np.abs(e)).conjugate()[:, None]
        gradient = self.limits[others] @ (unit * self.flat[others]).real
        first, second = (complex(column) for column in self.flat[corner])
        size = (first.conjugate() * second).imag
        # The force at the support, whose power at v_i is that of the gradient at y.
        needed = 1j * (second * gradient[0] - first * gradient[1]) / size
        # At the limit itself rounding decides; what lies below the corner is then of second order.
        if abs(needed) <= (1.0 + EDGE) * self.limits[corner]:
            return None
        along = needed / abs(needed)
        direction = [(along.conjugate() * second).imag, (first.conjugate() * along).imag]
        return np.array(direction) / size

    def minimum(self) -> Array:
        """The y of least dissipation, shape (2,)."""
        y, corner = self.lowest_corner()
        if corner >= 0:
            direction = self.descent(y, corner)
            if direction is None:
                return y
            y = _leave(self.value, y, direction, 1.0 + float(np.linalg.norm(y)))
        return lowest(self.limits, self.flat, self.offsets, y)


def _across(normal: Array) -> Array:
    """Two unit vectors, shape (3, 2), at right angles to each other and to the unit vector
    `normal`, by its reflection on an axis."""
    mirror = normal.copy()
    mirror[0] += math.copysign(1.0, mirror[0])
    columns = mirror[:, None] * (mirror[1:] * (-2.0 / float(mirror @ mirror)))
    columns[1, 0] += 1.0
    columns[2, 1] += 1.0
    return columns


def load_factor(limits: Array, arms: Complex, force: complex, torque: float) -> tuple[float, Array]:
    """Load factor of static friction under a wrench (the body sticks when it is 1 or less), and the
    velocity (x, y, angle), shape (3,), at which the body would start to move.

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
    normal = wrench / size
    maps = _velocity_maps(arms / length)
    basis = _across(normal)
    dissipation = _Dissipation(limits, maps @ basis, maps @ normal)
    y = dissipation.minimum()
    return size / dissipation.value(y), (normal + basis @ y) / [1.0, 1.0, length]


def excess_load(body: Mechanics, piece: Piece, time: float) -> float:
    """Load factor of static friction at local `time` [s], less 1: the body sticks up to 0."""
    at = configuration(body, piece, np.array([time]))
    force, torque = needed_wrench(body, at)
    return load_factor(at.limits[0], at.arms[0], complex(force[0]), float(torque[0]))[0] - 1.0


def holding_limit(capsule: Capsule, place: complex, direction: float) -> float:
    """Largest |w| [m/s^2] of the slider at `place` relative to C [m], along `direction` [rad, from
    the body's x axis], that leaves the body at rest: the load is proportional to |w|. Along lines
    through C it is f g/mu (Chernousko 2020, eq. 21)."""
    trial = capsule.holding_acceleration
    piece = StraightPiece(1.0, (place.real, place.imag), direction, 0.0, 0.0, trial)
    return trial / (1.0 + excess_load(mechanics(capsule), piece, 0.0))


def held_until(body: Mechanics, piece: Piece, start: float, duration: float) -> float | None:
    """First local time [s] after `start` at which static friction no longer suffices, or None if it
    does until `duration` [s]; on a piece of infinite duration nothing changes."""
    from scipy.optimize import brentq

    if not np.isfinite(duration):
        return None
    fractions = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, SAMPLES)))
    times = start + (duration - start) * fractions
    at = configuration(body, piece, times)
    held = simply_held(at, *needed_wrench(body, at))

    def excess(time: float) -> float:
        return excess_load(body, piece, time)

    for k in np.flatnonzero(~held):
        if k == 0 or excess(float(times[k])) <= EDGE:
            continue
        low, high = float(times[k - 1]), float(times[k])
        if excess(low) >= 0.0:
            return low
        return float(brentq(excess, low, high, xtol=1e-300, rtol=1.6e-15))
    return None
