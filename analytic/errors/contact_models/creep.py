"""The creep of bodies that stick on several soft contacts, with any joints between them.

A soft contact of MuJoCo (analytic/errors/contact_models/soft_friction.py has its law) resists a
slip v by a force that is linear in v, until it reaches the friction limit. At rest under loads,
bodies creep at the velocity at which all friction forces balance the loads. Normal forces, springs
and servos change with the creep as their stiffness lets them: they have followed it for a while.

Elliptic cone: F = min(b v/R_t, mu N) with R_t = R mu_1^2/(mu^2 ratio). Pyramid: along the tangent
i, the two edges push with f = max(0, k d r -+ b mu_i v_i)/R_e at a depth r; all edges of a contact
carry N, which gives r, and F_i = mu_i times the difference of the two.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import brentq

from plumbob.analytic.errors.contact_models.soft_friction import depth_under, impedance, rates
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import SoftPoint

# Each iteration replaces the resistance by the ratio of force to speed, which lowers a convex
# energy. Contacts near their limits need the most iterations.
MOST_CREEP_ITERATIONS = 2000
UNCHANGED = 1e-9  # relative change of all velocities that ends the iterations
# [m/s] speed below which the ratio of force to speed is that of rest: far below every creep of
# interest
NO_SPEED = 1e-15
# [s] A creep is resisted by normal forces, springs and servos like by dampers, whose constant is
# the stiffness times this time. If they were rigid, fingers whose faces are not parallel would
# lock; in truth the forces change little in this time. Between 10 s and 1000 s, predictions for
# fingers on hinges, stacks and a robot on legs differ by less than 2 %.
CREEP_TIME = 100.0
SHALLOWEST = 1e-9  # [m] smallest depth of a contact whose stiffness counts


@dataclass(frozen=True)
class SoftRows:
    """A soft contact in n velocity coordinates that carries a load."""

    # Rows of the normal velocity and of k velocities that friction resists, shape (1 + k, n)
    rows: Array
    friction: Array  # coefficients of friction [1 or m], shape (k,)
    load: float  # [N] normal force
    weight: float  # [1/kg] inverse effective mass by which the engine regularises the contact
    point: SoftPoint
    # Damping [1/s] of the tangential rows; None: the damping of the normal row
    friction_damping: float | None = None

    def normal_resistance(self, step: float) -> float:
        """Returns what resists a slow normal velocity [N s/m]."""
        depth = depth_under(self.point, self.load * self.weight, step)
        return CREEP_TIME * self.load / max(depth, SHALLOWEST)

    def damping(self, step: float) -> float:
        """Returns the damping b of the tangential rows [1/s]."""
        own = self.friction_damping
        return rates(self.point, step)[1] if own is None else own

    def elliptic_resistances(self, step: float, slips: Array) -> Array:
        """Returns the friction force over the slip [N s/m] along each tangential row."""
        depth = depth_under(self.point, self.load * self.weight, step)
        d = impedance(self.point, depth)
        softness = (1.0 - d) / d * self.weight / self.point.ratio
        stick = self.damping(step) / softness * (self.friction / self.friction[0]) ** 2
        # The cone limits |F_i/mu_i|.
        force = float(np.linalg.norm(stick * slips / self.friction))
        limited = min(1.0, self.load / force) if force else 1.0
        return np.asarray(stick * limited)

    def pyramid_resistances(self, step: float, slips: Array) -> Array:
        """Returns the friction force over the slip [N s/m] along each tangential row."""
        mu = self.friction
        ratio = 2.0 * mu[0] ** 2 * (1.0 + mu[0] ** 2) / self.point.ratio
        stiffness, _ = rates(self.point, step)
        lags = self.damping(step) * mu * np.abs(slips)

        def edges(depth: float) -> tuple[float, Array, Array]:
            """Returns the softness of an edge, and the forces of both edges along each tangent."""
            d = impedance(self.point, depth)
            softness = ratio * (1.0 - d) / d * self.weight
            push = stiffness * d * depth
            return softness, np.maximum(push - lags, 0.0) / softness, (push + lags) / softness

        def excess(depth: float) -> float:
            """Returns by how much the edges carry more than the load [N]."""
            _, low, high = edges(depth)
            return float((low + high).sum()) - self.load

        # The edge along a slip pushes at any depth.
        deepest = depth_under(self.point, ratio * self.load * self.weight, step)
        depth = float(brentq(excess, 0.0, deepest, xtol=1e-18)) if excess(0.0) < 0.0 else 0.0
        softness, low, high = edges(depth)
        sticks = 2.0 * mu**2 * self.damping(step) / softness
        slow = np.abs(slips) < NO_SPEED
        return np.where(slow, sticks, mu * (high - low) / np.where(slow, 1.0, np.abs(slips)))

    def resistances(self, step: float, slips: Array) -> Array:
        """Returns the friction force over the slip [N s/m] along each tangential row, at the slips
        [m/s], shape (k,), in steps of `step` [s]."""
        if self.point.pyramidal:
            return self.pyramid_resistances(step, slips)
        return self.elliptic_resistances(step, slips)


def steady_creep(
    contacts: tuple[SoftRows, ...], load: Array, held: Array, joints: Array, step: float
) -> Array | None:
    """Returns the velocity, shape (n,), at which the friction of `contacts` balances a `load`,
    shape (n,), in steps of `step` [s]. `held` are further rows of velocities that are 0, shape (h,
    n), and `joints` is the resistance of joints, shape (n, n). None if friction does not balance
    the load."""
    if any(math.isinf(c.point.ratio) for c in contacts if len(c.friction)):
        return np.zeros(len(load))
    normals = np.array([contact.rows[0] for contact in contacts])
    loads = np.array([contact.load for contact in contacts])
    stiff = np.array([contact.normal_resistance(step) for contact in contacts])
    without_friction = joints + normals.T @ (stiff[:, None] * normals)
    basis = null_space(held) if len(held) else np.eye(len(load))
    pull = basis.T @ (load + normals.T @ loads)
    velocity = np.zeros(len(load))
    for _ in range(MOST_CREEP_ITERATIONS):
        resistance = _with_friction(without_friction, contacts, velocity, step)
        reduced = basis.T @ resistance @ basis
        last_velocity = velocity
        velocity = np.asarray(basis @ np.linalg.lstsq(reduced, pull, rcond=1e-14)[0])
        change = np.abs(velocity - last_velocity).max(initial=0.0)
        if change <= UNCHANGED * np.abs(velocity).max(initial=0.0):
            return velocity
    return None


def _with_friction(
    resistance: Array, contacts: tuple[SoftRows, ...], velocity: Array, step: float
) -> Array:
    """Returns a resistance, shape (n, n), plus the resistance of friction at a velocity, shape
    (n,), in steps of `step` [s]."""
    total = resistance.copy()
    for contact in contacts:
        rows = contact.rows[1:]
        if len(rows):
            coefficients = contact.resistances(step, rows @ velocity)
            total += rows.T @ (coefficients[:, None] * rows)
    return total
