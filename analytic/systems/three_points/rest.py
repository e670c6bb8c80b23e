"""Coulomb points at rest: whether static friction suffices, and until when.

The body sticks when a.n <= sum f N_i |G_i a| for every acceleration a = (x, y, angle) of the body,
G_i a being that of support i and n the wrench that moves the body: n then lies in the sum of the
friction discs. How motion starts, where it does not, is decided in `implicit_friction`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

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
PARALLEL = 1e-12  # determinant of a support's map, below which no velocity lets it rest
EDGE = 1e-12  # a wrench this near the friction limit, relatively, counts as within it
SURELY = 1.0 + 1e-9  # above 1 whatever the rounding
SAMPLES = 65  # of a rest, for the first time at which friction does not suffice


def needed_wrench(body: Mechanics, at: Configuration) -> tuple[Complex, Array]:
    """Force [N] and torque about G [N m] that friction must balance for the body to stay at rest,
    shape (n,): the slider's reaction -m w."""
    force = -body.mass * body.mass_ratio * at.acceleration
    return np.asarray(force), -body.reduced_mass * cross(at.position, at.acceleration)


def simply_held(
    limits: Sequence[float], arms: Sequence[complex], force: complex, torque: float
) -> bool:
    """Whether friction f N_i (X + Y k x b_i), with b_i the arms from the centre of the `limits` f
    N_i [N], balances a `force` [N] and a `torque` [N m] about the point that the `arms` [m] are
    from: a sufficient condition."""
    total = sum(limits)
    if not total > 0.0:
        return False
    along = force / total
    if abs(along) > SURELY:  # the mean of the three sums below, each of which is 1 at most
        return False
    centre = sum(limit * arm for limit, arm in zip(limits, arms, strict=True)) / total
    around = [arm - centre for arm in arms]
    spread = sum(limit * abs(arm) ** 2 for limit, arm in zip(limits, around, strict=True))
    if not spread > 0.0:
        return False
    push = 1j * (torque - total * (centre.conjugate() * along).imag) / spread
    return all(abs(along + push * arm) <= 1.0 for arm in around)


@dataclass(frozen=True)
class _Dissipation:
    """sum f N_i |v_i(y)| over a plane of velocities, v_i = flat_i y + offset_i, of shapes (3, 2, 2)
    and (3, 2): convex in y, and not smooth at each pivot, where a v_i vanishes."""

    limits: Array
    flat: Array
    offsets: Array

    def velocities(self, y: Array) -> Array:
        """Velocities v_i, shape (3, 2)."""
        return np.asarray(self.flat @ y + self.offsets)

    def value(self, y: Array) -> float:
        """The sum."""
        return float(self.limits @ np.linalg.norm(self.velocities(y), axis=1))

    def minimum(self) -> Array:
        """The y of least dissipation, shape (2,): the lowest pivot where its support needs no more
        than its friction limit, else below that, where no step of Newton's method reaches a
        pivot."""
        pivots = {
            i: np.linalg.solve(self.flat[i], -self.offsets[i])
            for i in np.flatnonzero(np.abs(np.linalg.det(self.flat)) > PARALLEL)
        }
        support = min(pivots, key=lambda i: self.value(pivots[i]))
        corner, others = pivots[support], np.arange(3) != support
        velocities = self.velocities(corner)[others]
        directions = velocities / np.linalg.norm(velocities, axis=1)[:, None]
        gradient = np.einsum("i,ij,ijk", self.limits[others], directions, self.flat[others])
        needed = np.linalg.solve(self.flat[support].T, -gradient)
        size = float(np.linalg.norm(needed))
        # At the limit itself rounding decides; what lies below the corner is then of second order.
        if size <= (1.0 + EDGE) * self.limits[support]:
            return np.asarray(corner)
        reach = (1.0 + float(np.linalg.norm(corner))) / size
        way, level = np.linalg.solve(self.flat[support], reach * needed), self.value(corner)
        while way.any() and not self.value(corner + way) < level:
            way = 0.5 * way
        return self.lowest(corner + way)

    def lowest(self, y: Array) -> Array:
        """The minimum by Newton's method with halving from `y`, below the value at every pivot."""
        for _ in range(NEWTON_STEPS):
            velocities = self.velocities(y)
            speeds = np.linalg.norm(velocities, axis=1)
            directions = velocities / speeds[:, None]
            across = np.einsum("ij,ijk->ik", directions[:, ::-1] * [-1.0, 1.0], self.flat)
            gradient = np.einsum("i,ij,ijk", self.limits, directions, self.flat)
            step = -np.linalg.solve((across.T * (self.limits / speeds)) @ across, gradient)
            level, slope = float(self.limits @ speeds), float(gradient @ step)
            if -slope <= 2e-15 * level:
                # The gain is below round-off; the step is still taken, since it squares the error.
                return np.asarray(y + step)
            part = 1.0
            while part > 1e-12 and self.value(y + part * step) > level + 1e-4 * part * slope:
                part *= 0.5
            y = y + part * step
        return y


def load_factor(limits: Array, arms: Complex, force: complex, torque: float) -> tuple[float, Array]:
    """Load factor of static friction under a wrench (the body sticks when it is 1 or less), and the
    velocity (x, y, angle), shape (3,), at which the body would start to move.

    Largest of (wrench . q)/sum f N_i |v_i(q)| over velocities q; `limits` f N_i [N] and `arms` from
    G [m], shape (3,); `force` [N] and `torque` [N m] about G.
    """
    length = float(np.sqrt(np.mean(np.abs(arms) ** 2)))
    wrench = np.array([force.real, force.imag, torque / length])
    size = float(np.linalg.norm(wrench))
    if not np.isfinite(size):
        raise OverflowError("a double does not hold the size of the wrench")
    if size == 0.0:
        return 0.0, np.zeros(3)
    if not limits.any():
        return np.inf, wrench / [1.0, 1.0, length]
    maps = np.zeros((3, 2, 3))  # of velocities to those of the supports
    maps[:, 0, 0] = maps[:, 1, 1] = 1.0
    maps[:, 0, 2], maps[:, 1, 2] = -arms.imag / length, arms.real / length
    normal = wrench / size
    plane = np.linalg.svd(normal[None])[2][1:].T  # q = normal + plane y: the power is |wrench|
    dissipation = _Dissipation(limits, maps @ plane, maps @ normal)
    y = dissipation.minimum()
    return size / dissipation.value(y), (normal + plane @ y) / [1.0, 1.0, length]


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


def held_until(body: Mechanics, piece: Piece, start: float) -> float | None:
    """First local time [s] after `start` at which static friction no longer suffices, or None if it
    does to the end of the `piece`; where that has no end nothing changes."""
    from scipy.optimize import brentq

    if not np.isfinite(duration := piece.duration):
        return None
    fractions = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, SAMPLES)))
    times = start + (duration - start) * fractions
    at = configuration(body, piece, times)
    pulls, excess = zip(*needed_wrench(body, at), strict=True), partial(excess_load, body, piece)
    for k, (limits, arms, pull) in enumerate(zip(at.limits, at.arms, pulls, strict=True)):
        if k == 0 or simply_held(limits, arms, *pull) or excess(float(times[k])) <= EDGE:
            continue
        low, high = float(times[k - 1]), float(times[k])
        if excess(low) >= 0.0:
            return low
        return float(brentq(excess, low, high, xtol=1e-300, rtol=1.6e-15))
    return None
