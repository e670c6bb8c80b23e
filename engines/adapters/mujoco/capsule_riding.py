"""The capsule on contacts that yield: what its riding and tilting take from the loads of statics.

The contacts' depths c N_i, affine in the slider's place r, put C at a height z and give the body's
plane a gradient g, so the slider has the height q = z + g.r. With F_i the friction, a and b the
horizontal accelerations of C and Q, plane vectors as complex numbers in body axes, statics lacks

    sum dN_i     = M z'' + m q''
    sum dN_i A_i = m q'' r + P - (q - z) m b - z sum F_i + sum z_i F_i/2,
    P = I_a (g'' + 2i w g' + (i w' - w^2) g) + J (w^2 g - i w' g - i w g')

where w is the body's rate and I_a its inertia across: vertical inertia, gyroscopic moments, and
moments of horizontal forces at their heights. A contact acts halfway down its depth.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule, load_shares, normal_forces
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.slider_path import SliderPath
from plumbob.analytic.systems.three_points.equations import Complex
from plumbob.analytic.systems.three_points.friction import Start, three_point_motion
from plumbob.engines.adapters.mujoco.capsule_model import tilt_inertia
from plumbob.engines.adapters.mujoco.capsule_sag import share_slopes

PLACES = 33  # in each piece of the slider's motion, for what is smooth within one
LATE = 257  # after the last one, where friction alone acts
STILL = 1e-9  # of the largest slip: below it a support is at rest


@dataclass(frozen=True)
class Riding:
    """The exact motion at times [s], shape (n,), the slider's part of it as x + iy in body axes,
    arms CA_i - mu r and slips of the supports, shape (3, n)."""

    times: Array
    place: Complex
    speed: Complex
    push: Complex
    rate: Array  # of the body [rad/s]
    ground: Array  # |velocity of C| [m/s]
    mass: float  # M + m [kg]
    inertia: Array  # about the combined centre [kg m^2], shape (n,)
    arms: Complex
    slips: Complex  # [m/s]; zero where a support is at rest
    limits: Array  # f N_i [N], shape (3, n)

    @property
    def resting(self) -> Any:
        """Whether body and slider are at rest, shape (n,)."""
        return (np.abs(self.slips).max(axis=0) == 0.0) & (self.speed == 0.0)

    @property
    def directions(self) -> Complex:
        """Of the slips; zero where a support is at rest."""
        size = np.abs(self.slips)
        return np.asarray(self.slips / np.where(size > 0.0, size, 1.0))


def ridden(problem: CapsuleProblem, duration: float) -> Riding:
    """The motion, or the first of a train of them, until `duration` [s], finely in each piece."""
    motion, setup = problem.motion, problem.setup
    path: SliderPath = motion.single.path
    start = Start(velocity=setup.velocity, angular_velocity=setup.heading_rate)
    return _followed(setup.capsule, path, start, min(duration, getattr(motion, "period", duration)))


@lru_cache(maxsize=8)  # every method and step of a scene asks for the same
def _followed(capsule: Capsule, path: SliderPath, start: Start, end: float) -> Riding:
    edges = np.unique(np.append(np.minimum(path.breakpoints, end), [0.0, end]))
    counts = [PLACES] * (len(edges) - 2) + [LATE]
    parts = [
        np.linspace(a, b, n, endpoint=False)
        for (a, b), n in zip(pairwise(edges.tolist()), counts, strict=True)
    ]
    times = np.append(np.concatenate(parts), end)
    place, speed, push = (_complex(part) for part in path.kinematics(times))
    seen = three_point_motion(capsule, path, start).at(times)
    ground = _complex(seen.velocity) * np.exp(-1j * seen.heading)
    supports, mu = _complex(np.asarray(capsule.supports)), capsule.mass_ratio
    slips = np.asarray(ground + 1j * seen.angular_velocity * supports[:, None])
    slips = np.where(np.abs(slips) > STILL * np.abs(slips).max(), slips, 0.0)
    loads = normal_forces(capsule, np.stack([place.real, place.imag], axis=-1)).T
    return Riding(
        times, place, speed, push, seen.angular_velocity, np.abs(ground),
        mass=capsule.body_mass + capsule.slider_mass,
        inertia=capsule.inertia + mu * capsule.body_mass * np.abs(place) ** 2,
        arms=supports[:, None] - mu * place,
        slips=slips,
        limits=capsule.friction * loads,
    )  # fmt: skip


def _complex(vectors: Array) -> Complex:
    """Plane vectors, shape (n, 2), as x + iy."""
    return np.asarray(vectors[:, 0] + 1j * vectors[:, 1])


def missing_loads(problem: CapsuleProblem, motion: Riding, compliance: float) -> Array:
    """dN_i [N], shape (3, n), of contacts that yield by `compliance` [m/N] (module docstring)."""
    capsule, across = problem.setup.capsule, tilt_inertia(problem)
    r, v, w, rate = motion.place, motion.speed, motion.push, motion.rate
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    here, ahead, aside = -compliance * normal_forces(capsule, corners)
    tilting, central = share_slopes(problem) @ [1.0, 1j], load_shares(capsule, np.zeros(2))

    def heights(vector: Complex) -> tuple[Array, Array, Complex]:
        """Change of depths (3, n), of C's height and of the gradient with r by `vector`."""
        depths = np.outer(ahead - here, vector.real) + np.outer(aside - here, vector.imag)
        return depths, central @ depths, tilting @ depths

    (depths, z, g), (_, _, g1), (_, z2, g2) = heights(r), heights(v), heights(w)
    depths, z, g = depths + here[:, None], z + central @ here, g + tilting @ here
    over = (g.conjugate() * r).real
    lifted = z2 + (g2.conjugate() * r + 2.0 * g1.conjugate() * v + g.conjugate() * w).real
    friction = -motion.limits * motion.directions
    dragged, mu = friction.sum(axis=0), capsule.mass_ratio
    torque = (motion.arms.conjugate() * friction).imag.sum(axis=0)
    carried = w + 2j * rate * v - rate**2 * r
    spun = (torque - mu * capsule.body_mass * (r.conjugate() * carried).imag) / motion.inertia
    drawn = mu * (capsule.body_mass * (carried + 1j * spun * r) + dragged)
    total = capsule.body_mass * z2 + capsule.slider_mass * lifted
    gyration = across * (g2 + 2j * rate * g1 + (1j * spun - rate**2) * g)
    gyration += capsule.inertia * (rate**2 * g - 1j * spun * g - 1j * rate * g1)
    moment = capsule.slider_mass * lifted * r + gyration - over * drawn - z * dragged
    moment += 0.5 * (depths * friction).sum(axis=0)
    return np.asarray(np.outer(central, total) + (tilting.conjugate()[:, None] * moment).real)
