"""Force and power of the slider's actuators in a plane motion."""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial.legendre import leggauss

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_motion import Demand
from plumbob.analytic.systems.three_points.balance import actuator_force, exchange
from plumbob.analytic.systems.three_points.equations import Complex
from plumbob.analytic.systems.three_points.motion import ThreePointMotion

NODES = 16  # Gauss points of a segment, for the mean square; for the peak its ends as well


def driven_forces(motion: ThreePointMotion) -> tuple[Array, Complex, Complex]:
    """Weights in an integral over time [s], force of the actuators on the slider
    [N] and its velocity in the body [m/s], body axes, until the slider stops, each shape (n,)."""
    x, weights = leggauss(NODES)
    fractions = np.concatenate([[0.0], 0.5 * (x + 1.0), [1.0]])
    weights = np.concatenate([[0.0], 0.5 * weights, [0.0]])
    stop = motion.path.duration
    parts = []
    for begin, segment in zip(motion.begins, motion.segments, strict=True):
        if begin >= stop * (1.0 - 1e-12) or not np.isfinite(segment.end):
            continue
        load, pace = exchange(motion, segment, fractions)
        parts.append((weights * pace, actuator_force(motion.body, load), load.at.velocity))
    if not parts:
        none = np.zeros(0)
        return none, none.astype(complex), none.astype(complex)
    spans, forces, speeds = (np.concatenate(part) for part in zip(*parts, strict=True))
    return spans, forces, speeds


def plane_demand(motion: ThreePointMotion) -> Demand:
    """The demand of `motion` until the slider stops: the magnitude of the force, and the power
    that it gives to the slider in the body."""
    spans, forces, speeds = driven_forces(motion)
    if not spans.size:
        return Demand(0.0, 0.0, 0.0)
    square = float(np.sum(spans * np.abs(forces) ** 2))
    return Demand(
        peak=float(np.abs(forces).max()),
        rms=math.sqrt(square / motion.path.duration),
        power=float(np.abs((forces.conjugate() * speeds).real).max()),
    )
