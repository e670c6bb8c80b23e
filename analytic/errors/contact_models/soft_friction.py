"""Rest on soft contacts: depth under a load, and drift under a force that friction holds.

A contact of MuJoCo (its documentation, "Computation", constraint model) has a row for each
direction in which it acts. With the impedance d, the acceleration a along a row and the force F of
the row satisfy

    a + R F = -b v - k d r,   R = (1 - d)/d w,   b = 2/(d_max T),   k = 1/(d_max T zeta)^2

with w the inverse mass that acts on the row and r < 0 the depth. Normal row: at rest under a load N
its depth is given by R N = k d |r|. Friction row: it has k = 0 and the softness R/impratio. If it
holds a force F, the contact drifts at v = R F/(impratio b). Pyramid: it has rows along its four
edges, each with the softness R_e = 2 mu^2 (1 + mu^2) R/impratio. As long as all four push, the
contact drifts at v = R_e F/(2 mu^2 b). If F exceeds half of the friction limit, one edge has let
go, and v = R_e (3 F/mu - N)/(2 mu b). The pyramid holds up to |F_1| + |F_2| = mu N.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, RK4, Scheme, SoftPoint

SOFT_FRICTION_SCHEMES = (EULER, RK4)
# coefficients of RK4's growth factor, highest first
RK4_GROWTH_COEFFICIENTS = (1 / 24, 1 / 6, 1 / 2, 1.0, 1.0)


def impedance(point: SoftPoint, depth: float) -> float:
    """Returns the impedance d at a `depth` [m]: two curves between the two values of `point`, which
    are parabolas by default."""
    at_surface, at_width = point.impedance
    fraction = min(depth / point.width, 1.0)
    if fraction <= point.midpoint:
        rise = fraction**point.power / point.midpoint ** (point.power - 1.0)
    else:
        fall = (1.0 - fraction) ** point.power
        rise = 1.0 - fall / (1.0 - point.midpoint) ** (point.power - 1.0)
    return float(at_surface + (at_width - at_surface) * rise)


def rates(point: SoftPoint, step: float) -> tuple[float, float]:
    """Returns the stiffness k [1/s^2] and damping b [1/s] of a contact in steps of `step` [s]."""
    largest_impedance = point.impedance[1]
    if point.direct is not None:
        stiffness, damping = point.direct
        return stiffness / largest_impedance**2, damping / largest_impedance
    time_constant = max(point.time_constant, 2.0 * step)
    stiffness = 1.0 / (largest_impedance * time_constant * point.damping_ratio) ** 2
    return stiffness, 2.0 / (largest_impedance * time_constant)


def depth_under(point: SoftPoint, push: float, step: float) -> float:
    """Returns the depth [m] at which a soft contact is at rest under a load; `push` [m/s^2] is the
    load times the inverse mass of the contact."""
    if not push:
        return 0.0
    stiffness, _ = rates(point, step)
    least_impedance = min(point.impedance)
    # With the least impedance at every depth the contact would be softer, and so deeper.
    deepest = push / (stiffness * least_impedance**2)

    def excess_force(depth: float) -> float:
        """Returns d times the force [m/s^2] of the spring that exceeds the load; zero at rest."""
        d = impedance(point, depth)
        return stiffness * d**2 * depth - (1.0 - d) * push

    return float(brentq(excess_force, 0.0, deepest, xtol=1e-18))


@dataclass(frozen=True)
class HeldContact:
    """A contact that carries a load and holds a tangential force by friction."""

    load: float  # [N] normal force
    friction: float  # coefficient of friction
    pull: Array  # [N] force along each of the two tangents, shape (2,)
    weight: float  # [1/kg] inverse effective mass of the contact
    mass: float  # [kg] part of the body's mass that this contact holds

    def holds(self, point: SoftPoint) -> bool:
        """Returns whether the tangential force is within the friction cone or pyramid."""
        force = np.abs(self.pull).sum() if point.pyramidal else np.hypot(*self.pull)
        return bool(force <= self.friction * self.load)

    def has_edges(self, point: SoftPoint) -> bool:
        """Returns whether the contact has the rows of a pyramid's edges; without friction it has
        only a normal row."""
        return point.pyramidal and self.friction > 0.0

    def edge_softness(self, point: SoftPoint) -> float:
        """Returns the softness of a pyramid's edge over the softness of a normal row."""
        return 2.0 * self.friction**2 * (1.0 + self.friction**2) / point.ratio

    def depth(self, point: SoftPoint, step: float, lag: float = 0.0) -> float:
        """Returns the depth of the contact [m].

        An edge of a pyramid carries a quarter of the load. If the edge against the pull has let go,
        the edge along the pull carries more, and the two edges across it carry half of the
        remaining load each. `lag` is the part of the final drift's speed that is still missing:
        while it is not 0, the edges across carry more.
        """
        if not self.has_edges(point):
            return depth_under(point, self.load * self.weight, step)
        along = float(np.abs(self.pull).max()) / self.friction
        if along <= self.load / 2.0:
            edge_load = self.load / 4.0
        else:
            final_load = (self.load - along) / 2.0
            edge_load = final_load + lag * (along - final_load) / 3.0
        return depth_under(point, self.edge_softness(point) * edge_load * self.weight, step)

    def drift(self, point: SoftPoint, step: float) -> tuple[Array, Array]:
        """Returns the final drift along each tangent [m/s] and the rate of approach [1/s].

        Both have the shape (2,). The difference to the final drift decays at the rate of approach.
        The contact's force is beta + alpha (b v + a), with mass a = pull - force.
        """
        d = impedance(point, self.depth(point, step))
        _, damping = rates(point, step)
        softness = (1.0 - d) / d * self.weight
        mu = self.friction
        alpha = np.full(2, point.ratio / softness)
        beta = np.zeros(2)
        if self.has_edges(point):
            edge_softness = self.edge_softness(point) * softness
            edge_let_go = np.abs(self.pull) > mu * self.load / 2.0
            alpha = np.where(edge_let_go, 2.0 / 3.0, 2.0) * mu**2 / edge_softness
            beta = np.where(edge_let_go, np.sign(self.pull) * mu * self.load / 3.0, 0.0)
        return (self.pull - beta) / (alpha * damping), damping / (1.0 + self.mass / alpha)

    def settling(self, point: SoftPoint, step: float) -> float:
        """Returns the relative change of the contact's softness while the drift builds up.

        If an edge of the pyramid has let go, the depth changes as the drift builds up, and with it
        the impedance. If this edge still holds at the start, it also takes a part of the body's
        acceleration until it lets go: `lag` is added.
        """
        along = np.abs(self.pull).max()
        half_limit = self.friction * self.load / 2.0
        if not self.has_edges(point) or along <= half_limit:
            return 0.0
        _, damping = rates(point, step)
        _, approach_rates = self.drift(point, step)
        lag = damping / float(approach_rates.min()) - 1.0
        d_first = impedance(point, self.depth(point, step, lag))
        d_last = impedance(point, self.depth(point, step))
        change = abs((1.0 - d_first) / d_first / ((1.0 - d_last) / d_last) - 1.0)
        edge_holds_at_first = along * (1.0 - lag) <= half_limit
        return lag + change if edge_holds_at_first else change


def held_drift(scheme: Scheme, held: HeldContact, step: float, counts: Array) -> Array:
    """Returns the drift [m] and its speed [m/s] along the pull, shape (2, n), of a body that starts
    at rest, after the numbers of steps `counts`, shape (n,).

    If friction does not hold the body, or the scheme or contact is not known, the result is empty,
    shape (0, n).
    """
    point = scheme.contact
    if point is None or scheme.integrator not in SOFT_FRICTION_SCHEMES or not held.holds(point):
        return np.empty((0, len(counts)))
    final_speeds, approach_rates = held.drift(point, step)
    decay = -step * approach_rates
    if scheme.integrator == EULER:
        factor = 1.0 + decay
        mean_factor = factor
    else:
        factor = np.asarray(np.polyval(RK4_GROWTH_COEFFICIENTS, decay), dtype=np.float64)
        mean_factor = (factor - 1.0) / decay
    missing = factor[:, None] ** counts  # fraction of the final speed that is still missing
    lost_steps = (mean_factor / (1.0 - factor))[:, None] * (1.0 - missing)
    distances = step * final_speeds[:, None] * (counts - lost_steps)
    speeds = final_speeds[:, None] * (1.0 - missing)
    direction = held.pull / (np.hypot(*held.pull) or 1.0)
    return np.asarray(direction @ np.array([distances, speeds]))
