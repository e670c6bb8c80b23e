"""Whether bodies at rest can begin to move where Coulomb friction could also hold them.

Balanced forces prove no rest: a box between two fixed walls balances at any preload, and falls
without one. The bodies hold for sure if the accelerations a and the forces f of

    M a = load + sum J_c^T f_c,    normal a_n >= 0, f_n >= 0, a_n f_n = 0,
    |f_t| <= f_n where a_t = 0,    f_t = -f_n a_t/|a_t| where it is not (scaled by the friction),

have no solution but a = 0 (J.-S. Pang, J. Trinkle, "Stability characterizations of rigid body
contact problems with Coulomb friction", ZAMM 80, 2000: strong stability). With slip accelerations s
that are given, a is the point next to the free acceleration, by the metric M, of the convex set

    a_n + s >= |a_t|    at each contact

and it solves the problem where s = |a_t| (V. Acary, F. Cadoux, C. Lemarechal, J. Malick, "A
formulation of the linear discrete Coulomb friction problem via convex optimization", ZAMM 91,
2011). The set grows with s. So s begins at its largest possible value, and falls to the largest
solution. Each point is that of a least-distance programme (C. Lawson, R. Hanson, "Solving Least
Squares Problems", 1974, chapter 23), whose cones gain half-spaces as they are needed.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import block_diag, null_space
from scipy.optimize import lsq_linear, nnls

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.coulomb_statics import CUT, MOST_CONE_CUTS, ContactRows, HeldLoads

# Least ratio of an acceleration to the free one that counts as motion. A programme is solved to
# about 1e-12.
MOVES = 1e-6
# A least-squares programme is solved if no descent is steeper than this: a right solution leaves
# 1e-15, a wrong solution of `nnls` 0.1.
STEEPEST_LEFT = 1e-8
# Largest ratio of a cone's violation to the free acceleration that counts as none: far below MOVES
CONE_ROUNDING = 1e-9
# The slips fall by the factor f^2/(1 + f^2) or less at a friction f and equal masses: at f = 10,
# 700 times bring them below CLOSE, the least margin that statics resolves.
MOST_FALLS = 1000
SETTLED_SLIPS = 1e-7  # relative change of all slips at which they have settled


def can_move(held: HeldLoads) -> bool | None:
    """Returns whether the bodies can begin to move from rest; None if it is not clear, because the
    slips do not settle, or a programme is not solved.

    >>> floor = ContactRows(np.eye(2)[::-1], np.array([0.6]), 0)
    >>> none = np.zeros((0, 2))
    >>> weight = np.array([0.0, -9.8])
    >>> cube = HeldLoads(np.eye(2), weight, (floor,), none, none, none, np.zeros(0), np.zeros(2))
    >>> can_move(cube)
    False
    """
    try:
        return _Motion(held).begins()
    except RuntimeError:  # the solver of a least-distance programme gives up
        return None


class _Motion:
    """The search for accelerations that Coulomb friction allows bodies at rest, in coordinates in
    which equalities hold."""

    def __init__(self, held: HeldLoads) -> None:
        with_dry = _dry_as_contacts(held)
        equalities = with_dry.scaled_rows(with_dry.equalities)
        basis = null_space(equalities) if len(equalities) else np.eye(len(with_dry.load))
        self.free = basis.T @ with_dry.scaled_load
        self.contacts = [rows @ basis for rows in with_dry.cone_rows]
        stops = with_dry.scaled_rows(with_dry.stops) @ basis
        self.stops = stops / np.maximum(np.linalg.norm(stops, axis=1), 1e-300)[:, None]
        # Unit directions of each contact whose half-spaces bound the friction cone from outside so
        # far; a programme whose solution leaves a cone adds a direction.
        self.cuts = [[*np.eye(len(r) - 1), *-np.eye(len(r) - 1)] for r in self.contacts]

    def begins(self) -> bool | None:
        """Returns whether the largest solution moves; None if it is not found."""
        size = float(np.linalg.norm(self.free))
        slips = np.array([size * np.linalg.norm(rows[1:]) for rows in self.contacts])
        for _ in range(MOST_FALLS):
            acceleration = self._nearest(slips)
            if np.linalg.norm(acceleration) <= MOVES * size:
                return False
            fallen = np.array([np.linalg.norm(r[1:] @ acceleration) for r in self.contacts])
            change = np.abs(fallen - slips).max(initial=0.0)
            if change <= SETTLED_SLIPS * fallen.max(initial=0.0):
                return True if self._settling_tells else None
            slips = fallen
        return None

    @property
    def _settling_tells(self) -> bool:
        """Whether slips that have settled differ from slips that fall. At a friction f, the
        relative fall is 1/f^2 or more, which is hidden below SETTLED_SLIPS if f is too large."""
        friction = max(
            (np.linalg.norm(rows[1:], 2) for rows in self.contacts if len(rows) > 1),
            default=0.0,
        )
        return bool(friction**2 * SETTLED_SLIPS < 1.0)

    def _nearest(self, slips: Array) -> Array:
        """Returns the acceleration next to the free one that the contacts allow at given
        `slips`."""
        for _ in range(MOST_CONE_CUTS):
            acceleration = self._least_distance(*self._half_spaces(slips))
            cut = False
            for rows, slip, cuts in zip(self.contacts, slips, self.cuts, strict=True):
                normal, tangential = rows[0] @ acceleration, rows[1:] @ acceleration
                amount = float(np.linalg.norm(tangential))
                if amount > normal + slip + CUT * amount + CONE_ROUNDING:
                    cuts.append(-tangential / amount)
                    cut = True
            if not cut:
                break
        return acceleration

    def _half_spaces(self, slips: Array) -> tuple[Array, Array]:
        """Returns the rows whose products with the acceleration are at least the limits, shapes
        (half-spaces, n) and (half-spaces,)."""
        rows = [self.stops]
        limits = [np.zeros(len(self.stops))]
        for contact, slip, cuts in zip(self.contacts, slips, self.cuts, strict=True):
            if cuts:
                rows.append(contact[0] + np.array(cuts) @ contact[1:])
                limits.append(np.full(len(cuts), -slip))
            else:
                rows.append(contact[:1])
                limits.append(np.zeros(1))
        return np.vstack(rows), np.concatenate(limits)

    def _least_distance(self, rows: Array, limits: Array) -> Array:
        """Returns the acceleration next to the free one at which all half-spaces are kept."""
        missing = limits - rows @ self.free
        if (missing <= 0.0).all():
            return self.free
        programme = np.vstack([rows.T, missing])
        target = np.zeros(len(programme))
        target[-1] = 1.0
        weights, _ = nnls(programme, target, maxiter=100 * len(rows))
        residual = programme @ weights - target
        if not _is_least(programme, residual):
            # Half-spaces that repeat each other can lead nnls to wrong weights.
            solved = lsq_linear(
                programme, target, (0.0, np.inf), "bvls", max_iter=100 * len(rows)
            )
            residual = programme @ solved.x - target
            if not _is_least(programme, residual):
                raise RuntimeError("a least-distance programme is not solved")
        return np.asarray(self.free - residual[:-1] / residual[-1])


def _is_least(programme: Array, residual: Array) -> bool:
    """Returns whether no larger weight of a column of the programme makes the residual smaller."""
    steepest = (programme.T @ residual) / np.linalg.norm(programme, axis=0)
    return bool(steepest.min() >= -STEEPEST_LEFT)


def _dry_as_contacts(held: HeldLoads) -> HeldLoads:
    """Returns the loads with each dry joint as a contact of friction 1, whose normal coordinate is
    one of its own, on which the largest dry friction presses."""
    count = len(held.dry)
    if not count:
        return held
    size = len(held.load)

    def widened(rows: Array) -> Array:
        """Returns rows with zeros for the new coordinates."""
        return np.hstack([rows, np.zeros((len(rows), count))])

    # An inertia like that of the joint keeps the scaled numbers alike.
    rows = held.scaled_rows(held.dry)
    inertia = 1.0 / np.square(np.linalg.norm(rows, axis=1))
    dry = [
        ContactRows(
            np.vstack([np.eye(size + count)[size + k], widened(held.dry[k : k + 1])]),
            np.ones(1),
            -1 - k,
        )
        for k in range(count)
    ]
    contacts = [ContactRows(widened(c.rows), c.friction, c.pair) for c in held.contacts]
    return HeldLoads(
        inertia=block_diag(held.inertia, np.diag(inertia)),
        load=np.concatenate([held.load, -held.dry_limits]),
        contacts=(*contacts, *dry),
        equalities=widened(held.equalities),
        stops=widened(held.stops),
        dry=np.zeros((0, size + count)),
        dry_limits=np.zeros(0),
        actuation=np.concatenate([held.actuation, np.zeros(count)]),
    )
