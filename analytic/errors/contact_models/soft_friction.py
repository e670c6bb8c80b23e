"""Rest on soft contacts: depths under a load, and the drift of what friction holds.

MuJoCo's regularised contact (its documentation, "Computation", constraint model) asks of each row
of a contact, with impedance d, that the acceleration a along it and its force F satisfy

    a + R F = -b v - k d r,   R = (1 - d)/d w,   b = 2/(d_max T),   k = 1/(d_max T zeta)^2

with w the inverse mass that acts there and r < 0 the depth. A row along the normal, at rest under
N, is R N = k d |r| deep. One of friction has k = 0 and R/impratio, so that a force F which it holds
drifts at v = R F/(impratio b). A pyramid has rows along its four edges, each with R_e = 2 mu^2
(1 + mu^2) R/impratio: while all push, that is v = R_e F/(2 mu^2 b); above half of its friction one
edge has let go, and v = R_e (3 F/mu - N)/(2 mu b); and it holds |F_1| + |F_2| <= mu N.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, RK4, Scheme, SoftPoint

STEPPED = (EULER, RK4)
GROWTH = (1 / 24, 1 / 6, 1 / 2, 1.0, 1.0)  # of RK4 in a step, as a polynomial


def impedance(point: SoftPoint, depth: float) -> float:
    """d at a `depth` [m]: two parabolas between its two values."""
    part = min(depth / point.width, 1.0)
    (least, most) = point.impedance
    return least + (most - least) * (2 * part**2 if part < 0.5 else 1 - 2 * (1 - part) ** 2)


def rates(point: SoftPoint, step: float) -> tuple[float, float]:
    """Stiffness k [1/s^2] and damping b [1/s] of a contact in steps of `step` [s]."""
    most = point.impedance[1]
    time = max(point.time_constant, 2.0 * step)
    return 1.0 / (most * time * point.damping_ratio) ** 2, 2.0 / (most * time)


def depth_under(point: SoftPoint, push: float, step: float) -> float:
    """Depth [m] at which a row rests under a force over its inverse mass, `push` [m/s^2]."""
    stiffness, _ = rates(point, step)

    def excess(depth: float) -> float:
        d = impedance(point, depth)
        return stiffness * d**2 * depth - (1.0 - d) * push

    least = point.impedance[0]
    return (
        float(brentq(excess, 0.0, push / (stiffness * least**2), xtol=1e-18)) if push else 0.0
    )


@dataclass(frozen=True)
class Held:
    """A contact that carries `load` [N], with `friction`, and holds a `pull` along each of its
    tangents [N], shape (2,), where `weight` [1/kg] is the inverse mass that acts there, and the
    contact has a part `mass` [kg] of the body to itself."""

    load: float
    friction: float
    pull: Array
    weight: float
    mass: float

    def holds(self, point: SoftPoint) -> bool:
        """Whether the force is within the cone, or the pyramid."""
        pulled = np.abs(self.pull).sum() if point.pyramidal else np.hypot(*self.pull)
        return bool(pulled <= self.friction * self.load)

    def edged(self, point: SoftPoint) -> bool:
        """Whether the contact is a pyramid; without friction it has the normal alone."""
        return point.pyramidal and self.friction > 0.0

    def edge(self, point: SoftPoint) -> float:
        """Softness of a pyramid's edge over that of a row."""
        return 2.0 * self.friction**2 * (1.0 + self.friction**2) / point.ratio

    def depth(self, point: SoftPoint, step: float, lag: float = 0.0) -> float:
        """Depth of the contact [m]; an edge carries a quarter of the load, or where one has let go,
        half of what the ones along it leave: more while they lack the part `lag` of their slip."""
        if not self.edged(point):
            return depth_under(point, self.load * self.weight, step)
        along = float(np.abs(self.pull).max()) / self.friction
        even = along <= self.load / 2.0
        across = self.load / 4.0 if even else (self.load - along) / 2.0
        across += 0.0 if even else lag * (along - across) / 3.0
        return depth_under(point, self.edge(point) * across * self.weight, step)

    def drift(self, point: SoftPoint, step: float) -> tuple[Array, Array]:
        """The speed along each tangent in the end [m/s], and the rate [1/s] at which what it lacks
        of that falls off, shape (2,) each: with a force beta + alpha (b v + a), mass a = pull -
        force."""
        d = impedance(point, self.depth(point, step))
        damping = rates(point, step)[1]
        soft = (1.0 - d) / d * self.weight
        mu = self.friction
        firm = np.full(2, point.ratio / soft)
        base = np.zeros(2)
        if self.edged(point):
            edge = self.edge(point) * soft
            gone = np.abs(self.pull) > mu * self.load / 2.0
            firm = np.where(gone, 2.0 / 3.0, 2.0) * mu**2 / edge
            base = np.where(gone, np.sign(self.pull) * mu * self.load / 3.0, 0.0)
        return (self.pull - base) / (firm * damping), damping / (1.0 + self.mass / firm)

    def settling(self, point: SoftPoint, step: float) -> float:
        """Part of the softness that is not there yet when the drift begins: where an edge has let
        go, the depth and its impedance change as the slip grows; and an edge that has not yet let
        go holds more of the body's acceleration."""
        along = np.abs(self.pull).max()
        half = self.friction * self.load / 2.0
        if not self.edged(point) or along <= half:
            return 0.0
        lag = rates(point, step)[1] / float(self.drift(point, step)[1].min()) - 1.0
        first, last = (impedance(point, self.depth(point, step, x)) for x in (lag, 0.0))
        late = lag if along * (1.0 - lag) <= half else 0.0
        return late + abs((1.0 - first) / first / ((1.0 - last) / last) - 1.0)


def drifted(scheme: Scheme, held: Held, step: float, counts: Array) -> Array:
    """Way [m] and speed [m/s] along the pull after the numbers of steps `counts`, shape (n,), of
    what starts at rest: shape (2, n), the way first; empty where that is not known."""
    point = scheme.contact
    if point is None or scheme.integrator not in STEPPED or not held.holds(point):
        return np.empty((0, len(counts)))
    speeds, falls = held.drift(point, step)
    speeds = speeds[:, None]
    fall = -step * falls
    euler = scheme.integrator == EULER
    growth = 1.0 + fall if euler else np.polyval(GROWTH, fall)
    gained = growth if euler else (growth - 1.0) / fall
    powers = growth[:, None] ** counts
    ways = step * speeds * (counts - (gained / (1.0 - growth))[:, None] * (1.0 - powers))
    along = held.pull / (np.hypot(*held.pull) or 1.0)
    return np.asarray(along @ np.array([ways, speeds * (1.0 - powers)]))
