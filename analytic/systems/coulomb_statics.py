"""Bodies at rest on contacts with Coulomb friction: which forces balance their loads.

With v the n velocity coordinates, contacts exert the generalised force sum J_c^T f_c. A contact's
force f_c = (normal, tangential...) is in the cone |(f_i / mu_i)| <= normal. The bodies can be at
rest only if such forces, and forces of equalities, stops and dry joints, sum up to minus the load.

A cone is cut out of half-spaces step by step, from outside: where no forces within the half-spaces
balance the loads, no forces within the cones do. Every number is scaled by the inertia: with M = L
L^T, the coordinates are y = L^T a, so that loads and rows of all kinds of joints compare.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import linprog

from plumbob.analytic.reference import Array

# Largest part of the scaled load, which is 1, that may stay unbalanced: a tenth of it is the
# feasibility tolerance of the linear programme.
UNBALANCED = 1e-6
# Largest amount by which a tangential force exceeds the limit of its cone, as a fraction of the
# normal force, at which no half-space is added
CUT = 1e-4
FIRST_CUTS = 16  # half-spaces around a cone of two tangential forces at first
# An angle is halved with each cut: a single cone needs four of them for CUT. Many contacts that can
# share a load need more: then forces are looked for that are inside all cones for sure.
MOST_CONE_CUTS = 20
# Least distance of the smallest friction from the given one, as a part of it, that is resolved:
# ten times CUT
CLOSE = 1e-3
MOST_FRICTION = 64.0  # largest multiple of the given friction that is tried
FRICTION_HALVINGS = 12  # a multiple from 0 to 1 is known to 2^-12, a quarter of CLOSE
PENALTY = 1e4  # ratio of the cost of an unbalanced load to the cost of a force, each scaled


@dataclass(frozen=True)
class ContactRows:
    """A contact in n velocity coordinates."""

    # Rows of velocities at the contact, shape (1 + k, n): the normal velocity, positive where the
    # bodies separate, and k velocities that friction resists
    rows: Array
    friction: Array  # coefficients of friction of the k velocities [1 or m], shape (k,)
    pair: int  # number of the pair of bodies


@dataclass(frozen=True)
class HeldLoads:
    """Bodies at rest with n velocity coordinates, their loads and all that may hold them."""

    inertia: Array  # shape (n, n)
    load: Array  # generalised force without the contacts [N or N m], shape (n,)
    contacts: tuple[ContactRows, ...]
    equalities: Array  # rows of velocities that are always 0, shape (e, n)
    stops: Array  # rows of velocities that cannot be negative, shape (s, n)
    dry: Array  # rows of velocities that dry friction resists, shape (d, n)
    dry_limits: Array  # largest forces of dry friction [N or N m], shape (d,)
    actuation: Array  # the part of the load that actuators exert, shape (n,)

    @cached_property
    def root(self) -> Array:
        """The lower triangular L of the inertia L L^T."""
        return np.asarray(np.linalg.cholesky(self.inertia), dtype=float)

    def scaled_rows(self, rows: Array) -> Array:
        """Returns rows of velocities in the scaled coordinates, shape (len(rows), n)."""
        return np.asarray(solve_triangular(self.root, rows.T, lower=True)).T

    @cached_property
    def load_size(self) -> float:
        """The size of the load, scaled by the inertia [N / kg^(1/2)]; 1 without a load."""
        size = np.linalg.norm(solve_triangular(self.root, self.load, lower=True))
        return float(size) or 1.0

    @cached_property
    def scaled_load(self) -> Array:
        """The load in the scaled coordinates: of size 1, or 0."""
        return np.asarray(solve_triangular(self.root, self.load, lower=True)) / self.load_size

    @cached_property
    def scaled_actuation(self) -> Array:
        """The actuators' part of the scaled load."""
        scaled = solve_triangular(self.root, self.actuation, lower=True)
        return np.asarray(scaled) / self.load_size

    @cached_property
    def cone_rows(self) -> tuple[Array, ...]:
        """The rows of each contact, scaled so that the normal row is a unit vector and every
        coefficient of friction is 1. Rows without friction are left out."""
        scaled = list[Array]()
        for contact in self.contacts:
            rows = self.scaled_rows(contact.rows)
            rubs = contact.friction > 0.0
            tangential = contact.friction[rubs, None] * rows[1:][rubs]
            scaled.append(np.vstack([rows[:1], tangential]) / np.linalg.norm(rows[0]))
        return tuple(scaled)

    @cached_property
    def newtons(self) -> Array:
        """The ratio of each contact's normal force [N] to its scaled force, shape (contacts,)."""
        normals = [contact.rows[:1] for contact in self.contacts]
        sizes = [np.linalg.norm(self.scaled_rows(normal)) for normal in normals]
        return self.load_size / np.array(sizes).reshape(len(self.contacts))


@dataclass(frozen=True)
class ForceBalance:
    """Forces that balance loads."""

    normal_forces: Array  # [N] of each contact, shape (contacts,)
    objective: float  # the least value of what was asked to be small


@dataclass(frozen=True)
class Statics:
    """The answer of statics to whether bodies can be at rest."""

    # The smallest multiple of the friction with which forces balance the loads; infinite if none
    least_friction: float
    # [N] of each contact, shape (contacts,): forces whose largest sum over a pair of bodies is
    # smallest; empty if no forces balance the loads
    normal_forces: Array
    # [N] the largest normal force between two bodies, at its smallest; NaN if there is no balance
    least_force: float
    # The smallest multiple of the actuators' forces that holds; NaN without actuators or balance
    least_actuation: float
    least_grip: float  # [N] the largest normal force between two bodies with that multiple
    # The least multiple of the friction that balanced forces were seen to use; infinite without
    used_friction: float
    failed: bool  # whether the solver has failed

    @property
    def close(self) -> bool:
        """Whether the given friction is too near to the smallest one to tell, or no balanced forces
        within the cones were seen."""
        unseen = self.balanced and self.used_friction > 1.0 + CLOSE
        return abs(self.least_friction - 1.0) <= CLOSE or unseen or self.failed

    @property
    def balanced(self) -> bool:
        """Whether forces within the cones balance the loads."""
        return self.least_friction <= 1.0 + CLOSE

    @property
    def margin(self) -> float:
        """The part of the friction that is not needed; negative if more is needed."""
        return 1.0 - self.least_friction


class BalanceProgramme:
    """The linear programme of the forces that balance loads. Its cones gain half-spaces as they are
    needed, and keep them."""

    def __init__(self, held: HeldLoads) -> None:
        self.held = held
        self.sizes = [len(rows) for rows in held.cone_rows]
        self.starts = np.cumsum([0, *self.sizes])
        others = [held.scaled_rows(r) for r in (held.equalities, held.stops, held.dry)]
        columns = np.vstack([*held.cone_rows, *others]).T
        count = len(held.load)
        # The last columns: the actuation, the largest force of a pair, and unbalanced loads.
        slack = np.eye(count)
        actuation = held.scaled_actuation[:, None]
        self.matrix = np.hstack([columns, actuation, np.zeros((count, 1)), slack, -slack])
        self.actuator, self.largest = columns.shape[1], columns.shape[1] + 1
        self.bounds = self._bounds(count)
        self.cuts = [self._first_cuts(size - 1) for size in self.sizes]
        # The least multiple of the friction that balanced forces were seen to use
        self.used = math.inf
        self.failed = False  # whether the solver has failed

    def _bounds(self, count: int) -> list[tuple[float | None, float | None]]:
        """Returns the least and the largest value of each unknown."""
        held = self.held
        bounds: list[tuple[float | None, float | None]] = []
        for size in self.sizes:
            bounds += [(0.0, None), *[(None, None)] * (size - 1)]
        bounds += [(None, None)] * len(held.equalities) + [(0.0, None)] * len(held.stops)
        limits = (held.dry_limits / held.load_size).tolist()
        bounds += [(-limit, limit) for limit in limits]
        return [*bounds, (0.0, 0.0), (0.0, None), *[(0.0, None)] * (2 * count)]

    @staticmethod
    def _first_cuts(count: int) -> list[Array]:
        """Returns the normals of the first half-spaces of a cone with `count` tangential forces."""
        if count < 2:
            return [*np.eye(count), *-np.eye(count)]
        angles = np.arange(FIRST_CUTS) * math.tau / FIRST_CUTS
        around = np.zeros((FIRST_CUTS, count))
        around[:, 0], around[:, 1] = np.cos(angles), np.sin(angles)
        return [*around, *np.eye(count)[2:], *-np.eye(count)[2:]]

    def _half_spaces(self, friction: float) -> Array:
        """Returns the rows that must not be positive, shape (half-spaces, unknowns)."""
        rows = list[Array]()
        for start, cuts in zip(self.starts, self.cuts, strict=False):
            for cut in cuts:
                row = np.zeros(self.matrix.shape[1])
                row[start], row[start + 1 : start + 1 + len(cut)] = -friction, cut
                rows.append(row)
        pairs = np.array([contact.pair for contact in self.held.contacts], dtype=int)
        for pair in np.unique(pairs):
            row = np.zeros(self.matrix.shape[1])
            row[self.starts[:-1][pairs == pair]] = self.held.newtons[pairs == pair]
            row[self.largest] = -self.held.load_size
            rows.append(row)
        return np.array(rows).reshape(len(rows), self.matrix.shape[1])

    def balance(self, friction: float = 1.0, wanted: str = "") -> ForceBalance | None:
        """Returns forces that balance the loads at a multiple of the `friction`, or None if no such
        forces exist. `wanted` is "force" for the smallest largest force of a pair, and "actuation"
        for the smallest multiple of the actuators' forces."""
        cost = np.zeros(self.matrix.shape[1])
        cost[self.largest + 1 :] = 1.0 if not wanted else PENALTY
        bounds = self.bounds.copy()
        target = -self.held.scaled_load
        if wanted == "force":
            cost[self.largest] = 1.0
        elif wanted == "actuation":
            cost[self.actuator], bounds[self.actuator] = 1.0, (0.0, None)
            target = target + self.held.scaled_actuation
        for _ in range(MOST_CONE_CUTS):
            forces = self._forces(friction, cost, target, bounds)
            if forces is None:
                return None
            if not self._cut_off(forces, friction):
                break
        else:
            inside = self._forces(friction * self._inner_part, cost, target, bounds)
            forces = forces if inside is None else inside
            assert forces is not None
        if wanted != "actuation":
            self.used = min(self.used, self._used_friction(forces))
        normals = forces[self.starts[:-1]]
        index = self.actuator if wanted == "actuation" else self.largest
        return ForceBalance(normals * self.held.newtons, float(forces[index]))

    def _forces(
        self,
        friction: float,
        cost: Array,
        target: Array,
        bounds: list[tuple[float | None, float | None]],
    ) -> Array | None:
        """Returns all unknowns at their least cost within the half-spaces, or None if a load is
        left unbalanced."""
        half_spaces = self._half_spaces(friction)
        solved = linprog(
            cost,
            A_ub=half_spaces,
            b_ub=np.zeros(len(half_spaces)),
            A_eq=self.matrix,
            b_eq=target,
            bounds=bounds,
            method="highs",
        )
        if solved.x is None:
            # Unbalanced loads make every programme feasible: the solver has failed.
            self.failed = True
            return None
        balanced = solved.x[self.largest + 1 :].sum() <= UNBALANCED
        return np.asarray(solved.x) if balanced else None

    def _used_friction(self, forces: Array) -> float:
        """Returns the multiple of the friction that forces use."""
        used = 0.0
        for start, size in zip(self.starts, self.sizes, strict=False):
            amount = float(np.linalg.norm(forces[start + 1 : start + size]))
            if amount > UNBALANCED:
                used = max(used, amount / max(forces[start], UNBALANCED))
        return used

    @property
    def _inner_part(self) -> float:
        """The part of the friction with which the first half-spaces lie inside the cones."""
        # Forces of torsion and rolling are each within the whole friction.
        others = max(0, max(self.sizes) - 3)
        return 1.0 / math.sqrt(math.cos(math.pi / FIRST_CUTS) ** -2 + others)

    def _cut_off(self, forces: Array, friction: float) -> bool:
        """Adds a half-space for each contact whose force is outside its cone; returns whether there
        is one."""
        added = False
        for number, size in enumerate(self.sizes):
            start = self.starts[number]
            tangential = forces[start + 1 : start + size]
            amount = float(np.linalg.norm(tangential))
            if amount > (friction + CUT) * forces[start] + UNBALANCED:
                self.cuts[number].append(tangential / amount)
                added = True
        return added


def least_multiple(holds: Callable[[float], bool]) -> float:
    """Returns the smallest multiple at which something holds that holds at every larger one, to
    2^-FRICTION_HALVINGS of it; infinite if it does not hold at MOST_FRICTION."""
    low, high = 0.0, 1.0
    while not holds(high):
        low, high = high, 2.0 * high
        if high > MOST_FRICTION:
            return math.inf
    if not low and holds(0.0):
        return 0.0
    for _ in range(FRICTION_HALVINGS):
        middle = (low + high) / 2.0
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def contact_statics(held: HeldLoads) -> Statics:
    """Returns whether forces within the cones balance the loads, and with how little friction,
    force and actuation.

    >>> ramp = ContactRows(np.eye(2)[::-1], np.array([0.6]), 0)
    >>> none = np.zeros((0, 2))
    >>> slope = np.array([math.sin(0.3), -math.cos(0.3)])
    >>> cube = HeldLoads(np.eye(2), slope, (ramp,), none, none, none, np.zeros(0), np.zeros(2))
    >>> bool(abs(contact_statics(cube).least_friction - math.tan(0.3) / 0.6) < 3e-4)
    True
    """
    programme = BalanceProgramme(held)
    least = least_multiple(lambda multiple: programme.balance(multiple) is not None)
    friction = max(1.0, least + CUT)
    balance = programme.balance(friction, "force") if math.isfinite(least) else None
    if balance is None or least > 1.0 + CLOSE:
        return Statics(
            least_friction=least,
            normal_forces=np.zeros(0),
            least_force=math.nan,
            least_actuation=math.nan,
            least_grip=math.nan,
            used_friction=programme.used,
            failed=programme.failed,
        )
    actuation = programme.balance(friction, "actuation") if held.actuation.any() else None
    pairs = np.array([contact.pair for contact in held.contacts])
    sums = np.bincount(pairs, actuation.normal_forces) if actuation else np.full(1, math.nan)
    return Statics(
        least_friction=least,
        normal_forces=balance.normal_forces,
        least_force=balance.objective * held.load_size,
        least_actuation=actuation.objective if actuation else math.nan,
        least_grip=float(sums.max()),
        used_friction=programme.used,
        failed=programme.failed,
    )
