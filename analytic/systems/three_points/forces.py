"""Friction at the supports along a motion on three Coulomb points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import legder

from plumbob.analytic.numerics.collocation import evaluate
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.three_points.equations import (
    Complex,
    Configuration,
    configuration,
    cross,
    sliding_forces,
    support_velocities,
)
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.analytic.systems.three_points.pivoting import Pivot
from plumbob.analytic.systems.three_points.rest import needed_wrench
from plumbob.analytic.systems.three_points.smooth_segment import SmoothSegment, com_of


@dataclass(frozen=True)
class Loading:
    """Motion and friction of a segment at n times, plane vectors complex and in body axes.

    `support_forces` F_i [N], shape (n, 3), are not unique while the body rests, and NaN there;
    their sum `force` [N] and moment `torque` about G [N m] always are.
    """

    at: Configuration
    centre: Complex  # V of G [m/s]
    omega: Array  # [rad/s]
    heading: Array  # [rad]
    place: Complex  # of G on the ground [m]
    velocities: Complex  # of the supports [m/s], shape (n, 3)
    support_forces: Complex
    force: Complex
    torque: Array


def resting(motion: ThreePointMotion, segment: SmoothSegment, times: Array) -> Loading:
    """Loading of a segment in which the body rests, at local `times` [s], shape (n,)."""
    body, piece = motion.body, motion.piece(segment.piece)
    at = configuration(body, piece, times)
    com = com_of(body, piece, segment.first)
    heading = np.full(times.size, segment.first.heading)
    force, torque = needed_wrench(body, at)
    return Loading(
        at=at,
        centre=body.mass_ratio * at.velocity,
        omega=np.zeros(times.size),
        heading=heading,
        place=com + body.mass_ratio * at.position * np.exp(1j * heading),
        velocities=np.zeros((times.size, 3), dtype=np.complex128),
        support_forces=np.full((times.size, 3), np.nan + 0j),
        force=-force,
        torque=-torque,
    )


def moving(motion: ThreePointMotion, segment: SmoothSegment, places: Array) -> Loading:
    """Loading of a segment in which the body moves, at parameters `places`, shape (n,)."""
    assert segment.coefficients is not None
    body, piece = motion.body, motion.piece(segment.piece)
    px, py, omega, times, heading, x, y = evaluate(segment.coefficients, places).T
    at = configuration(body, piece, times)
    velocities = support_velocities(at, px + 1j * py, omega)
    forces = sliding_forces(at, velocities)
    if segment.mode == "pivot":
        velocities[:, segment.support] = 0.0
        forces = sliding_forces(at, velocities)
        sense = float(np.sign(omega[np.argmax(np.abs(omega))]))
        turning = Pivot(body, piece, segment.support, sense).motion(at, omega)
        forces[:, segment.support] = turning.needed_force
    elif segment.support >= 0:
        forces[:, segment.support] += _missing(motion, segment, places, at, forces)
    return Loading(
        at=at,
        centre=px + 1j * py + body.mass_ratio * at.velocity,
        omega=omega,
        heading=heading,
        place=x + 1j * y,
        velocities=velocities,
        support_forces=forces,
        force=forces.sum(axis=1),
        torque=cross(at.arms, forces).sum(axis=1),
    )


def _missing(
    motion: ThreePointMotion,
    segment: SmoothSegment,
    places: Array,
    at: Configuration,
    forces: Complex,
) -> Complex:
    """Force [N] that the acceleration of a segment needs in addition to `forces`, shape (n,).

    Where a support slips from rest its velocity is at first a difference of nearly equal numbers
    without a reliable direction; the acceleration of the motion still determines its friction.
    """
    assert segment.coefficients is not None
    body = motion.body
    px, py, omega, *_ = evaluate(segment.coefficients, places).T
    slopes = evaluate(np.asarray(2.0 * legder(segment.coefficients)), places)
    carried = px + 1j * py + body.mass_ratio * at.velocity
    change = (slopes[:, 0] + 1j * slopes[:, 1]) / slopes[:, 3]
    push = change + body.mass_ratio * at.acceleration + 1j * omega * carried
    return np.asarray(body.mass * push - forces.sum(axis=1))
