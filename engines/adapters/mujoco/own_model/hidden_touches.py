"""Touches of two geoms between two states of a motion, of which neither state shows anything.

An adaptive method accepts a step by what it finds at its stages: a ball that is before a card at
one stage and behind it at the next has met nothing. Conservative advancement tells whether that can
be: two convex geoms that are a distance d apart do not touch before they have approached by d.

How far they approach in a step of length h is bounded twice.

1. A point of a geom moves at |v| + |w| r at most, for its centre's velocity v, its angular velocity
   w and its radius r. The bound is PATH times the larger of this speed at the two ends, times h. A
   step that keeps a tolerance of 1e-8 is at most some 1.5 rad of an oscillation, whose speed at its
   middle is 1/cos(0.75) = 1.37 times that at the ends. Distances that two geoms have travelled are
   added up over steps, so that a pair is measured again only when these use its distance up.
2. If that does not do, the pair is looked at in the axes of its first geom, where a common motion
   is none, as points of the second one: the centre of a sphere, the ends of a capsule, the corners
   of a box or a mesh. Along the normal n of the shortest connection, fixed in these axes, a point p
   goes from one end's n·p to the other's, and leaves the line between them by a parabola of
   h²/8 of its largest acceleration at most, which is taken as twice the larger that the cubic
   through both ends' places and velocities has at an end. A cylinder or ellipsoid is its centre,
   and its turn brings its surface nearer by h r |n × w|, less the turn about an axis of symmetry.

Where neither excludes a touch, the motion at the middle is looked at, and both halves likewise. The
motion within a step is the polynomial of the method; where that leaves the second bound, its own
stages have met something, and the step is halved. Distances are those of `mj_geomDistance`, which
is exact to 2e-10 m for convex geoms; collisions take a mesh for its convex hull, too.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.colliding_pairs import colliding_pairs
from plumbob.engines.adapters.mujoco.own_model.readings import pair_name
from plumbob.engines.adapters.mujoco.own_model.solids import CORNERS
from plumbob.engines.adapters.mujoco.terms import put
from plumbob.engines.own_motion import NotCertifiable

GEOM = mujoco.mjtObj.mjOBJ_GEOM
KIND = mujoco.mjtGeom
SMOOTH = (int(KIND.mjGEOM_CYLINDER), int(KIND.mjGEOM_ELLIPSOID))
# about the third axis
SYMMETRIC = (KIND.mjGEOM_SPHERE, KIND.mjGEOM_CAPSULE, KIND.mjGEOM_CYLINDER)
PATH = 1.5  # times the speed at the ends of a step: see above
CURVED = 2.0  # times the acceleration at the ends of a step: see above
TURNED = 0.5  # [rad] in a step: beyond, its ends do not bound what is between
SHALLOW = 1e-9  # [m]: a touch no deeper is as good as none, distances are known to that
LOOKS = 4000  # states within a step that are looked at
TINY = np.finfo(float).tiny
FAR = 1e3  # [m]: larger distances are measured as that
BISECTIONS = 20  # of the time between a state that touches and one that does not
Motion = Callable[[float], Array]
"""The state at a time [s] within a step."""


@dataclass(frozen=True)
class Touch:
    """Times [s] from which and up to which two geoms touch; the middle of a step twice where it
    turns too far to tell."""

    begins: float
    ends: float


@dataclass(frozen=True)
class Pair:
    """Two geoms at a time: their distance, and points of the second in the axes of the first."""

    time: float  # [s]
    distance: float  # [m] less the margin: they touch where it is not positive
    normal: Array  # from the first to the second
    places: Array  # [m] of the points, shape (n, 3)
    velocities: Array  # [m/s], likewise
    spin: Array  # [rad/s] of the second, but for that about an axis of symmetry
    turning: float  # [rad/s] the faster of that and of these axes


@dataclass(frozen=True)
class Speeds:
    """The largest speed [m/s] of the surface of each geom, shape (geoms,), and the largest angular
    velocity [rad/s] of all at a time [s]."""

    time: float
    surfaces: Array
    spin: float


class HiddenTouches:
    """Looks at each step of an integration for pairs of geoms that touch within it and at neither
    end. The integration leaves the state that it has reached in the mjData `current`; `inside` is
    another one, for states within a step."""

    def __init__(self, model: Any, current: Any, inside: Any, start: Array) -> None:
        self.model, self.current, self.inside = model, current, inside
        pairs, margins = colliding_pairs(model)
        self.margins: list[float] = margins.tolist()
        kinds = model.geom_type
        self.radii = np.array(model.geom_rbound)
        # [m] by which a turn of 1 rad moves the surface; a plane is never the second of a pair
        levers = np.where(kinds == KIND.mjGEOM_PLANE, np.inf, self.radii)
        self.levers = np.where(kinds == KIND.mjGEOM_SPHERE, 0.0, levers)
        self.symmetric = np.isin(kinds, SYMMETRIC)
        swapped = self.levers[pairs[:, 0]] < self.levers[pairs[:, 1]]
        ordered = np.where(swapped[:, None], pairs[:, ::-1], pairs)
        self.pairs: list[list[int]] = ordered.tolist()
        self.first, self.second = np.ascontiguousarray(ordered.T)
        self.bodies = np.array(model.geom_bodyid)
        self.roots = model.body_rootid[self.bodies]
        self.travelled = np.zeros(model.ngeom)  # [m] by the surface of each geom, at most
        # [m] that two geoms may travel before their distance is to be measured again
        self.limits = np.zeros(len(pairs))
        self.touching = np.zeros(len(pairs), bool)
        self.last = self._speeds(self._placed(start), 0.0)

    def within(self, time: float, dense: Callable[[], Motion]) -> Touch | None:
        """A touch that the step up to `time` [s], whose motion `dense` gives, passes over: the step
        is to be repeated in parts. None where there is none; the next step then begins here. Raises
        NotCertifiable where geoms pass too close to each other to tell."""
        if not self.limits.size:
            return None
        last = self.last
        now = self._speeds(self.current, time)
        step = time - last.time
        paths = PATH * step * np.maximum(last.surfaces, now.surfaces)
        travelled = self.travelled + paths
        used = travelled[self.first] + travelled[self.second]
        due = np.flatnonzero(used >= self.limits)
        rows = due.tolist()
        gaps = [self._distance(self.current, row)[0] for row in rows]
        approach = (paths[self.first[due]] + paths[self.second[due]]).tolist()
        turns = 2.0 * step * max(last.spin, now.spin) > 2.0 * TURNED
        motion: Motion | None = None
        for row, gap, most in zip(rows, gaps, approach, strict=True):
            if gap > most:
                continue
            if gap <= SHALLOW or self.touching[row]:
                touch = Touch(*2 * [(last.time + time) / 2.0]) if turns else None
            else:
                motion = motion or dense()
                touch = self._passed(row, motion, last.time, time)
            if touch is not None:
                return touch
        measured = np.array(gaps)
        self.touching[due] = measured <= SHALLOW
        self.limits[due] = used[due] + np.maximum(measured, 0.0)
        self.travelled, self.last = travelled, now
        return None

    def _passed(self, row: int, motion: Motion, start: float, end: float) -> Touch | None:
        """A touch of a pair between two times [s]; None where there is none."""
        ahead = [(self._at(row, motion, start), self._at(row, motion, end))]
        for _ in range(LOOKS):
            if not ahead:
                return None
            one, other = ahead.pop()
            if self._apart(row, one, other):
                continue
            middle = self._at(row, motion, (one.time + other.time) / 2.0)
            if middle.distance <= 0.0:
                edges = (self._edge(row, motion, p.time, middle.time) for p in (one, other))
                return Touch(*edges)
            turned = (other.time - one.time) * max(one.turning, other.turning)
            off = _lengths(middle.places - (one.places + other.places) / 2.0)
            if turned <= TURNED and (off > _leaves(one, other) + SHALLOW).any():
                # Stages of the polynomial alone have met something: it is not the motion.
                return Touch(middle.time, middle.time)
            ahead += [(middle, other), (one, middle)]
        raise NotCertifiable(
            f"{pair_name(self.model, self.pairs[row])} pass too close to tell whether "
            f"they touch, from {ahead[-1][0].time:.4g} s on"
        )

    def _edge(self, row: int, motion: Motion, clear: float, touching: float) -> float:
        """The time [s] at which a pair begins or ceases to touch, on its touching side, between a
        time at which it is clear and one at which it touches."""
        for _ in range(BISECTIONS):
            middle = (clear + touching) / 2.0
            touches = self._at(row, motion, middle).distance <= 0.0
            clear, touching = (clear, middle) if touches else (middle, touching)
        return touching

    def _apart(self, row: int, one: Pair, other: Pair) -> bool:
        """Whether a pair cannot touch between two times: the second bound of the module."""
        kind = int(self.model.geom_type[self.second[row]])
        lever = float(self.levers[self.second[row]]) if kind in SMOOTH else 0.0
        step = other.time - one.time
        both = (one, other)
        speeds = [_lengths(p.velocities).max() + lever * _length(p.spin) for p in both]
        if one.distance + other.distance + SHALLOW > PATH * step * max(speeds):
            return True
        if step * max(one.turning, other.turning) > TURNED:
            return False
        moved = other.places - one.places
        leaves = _leaves(one, other)
        changed = _length(other.spin - one.spin)
        for pair, ways in ((one, moved), (other, -moved)):
            turn = max(_length(np.cross(pair.normal, p.spin)) for p in both) + changed
            along = pair.places @ pair.normal
            begin = pair.distance + along - along.min()
            end = begin + ways @ pair.normal - step * lever * turn
            if _least(begin, end, 4.0 * leaves).min() > -SHALLOW:
                return True
        return False

    def _distance(self, data: Any, row: int) -> tuple[float, Array]:
        """The distance [m] of a pair less its margin, and its shortest connection, shape (6,)."""
        ends = np.zeros(6)
        first, second = self.pairs[row]
        distance = mujoco.mj_geomDistance(self.model, data, first, second, FAR, ends)
        return distance - self.margins[row], ends

    def _at(self, row: int, motion: Motion, time: float) -> Pair:
        """A pair at a time [s] within a step."""
        data = self._placed(motion(time))
        distance, ends = self._distance(data, row)
        first, second = self.pairs[row]
        axes = data.geom_xmat[first].reshape(3, 3)
        connection = ends[3:] - ends[:3]
        (turn, start), (spin, velocity) = (
            np.split(self._velocity(data, geom), 2) for geom in (first, second)
        )
        arms = self._points(second) @ data.geom_xmat[second].reshape(3, 3).T
        places = data.geom_xpos[second] - data.geom_xpos[first] + arms
        velocities = velocity - start + np.cross(spin, arms) - np.cross(turn, places)
        spin = spin - turn
        if self.symmetric[second]:
            axis = data.geom_xmat[second][2::3]
            spin = spin - (spin @ axis) * axis
        return Pair(
            time,
            distance,
            connection @ axes / _length(connection),
            places @ axes,
            velocities @ axes,
            spin @ axes,
            max(_length(spin), _length(turn)),
        )

    def _points(self, geom: int) -> Array:
        """Points [m] of a geom in its own axes, whose hull, thickened by a radius, it is, shape
        (n, 3); of a cylinder or ellipsoid its centre."""
        model = self.model
        kind = model.geom_type[geom]
        if kind == KIND.mjGEOM_MESH:
            mesh = model.geom_dataid[geom]
            first = model.mesh_vertadr[mesh]
            corners = model.mesh_vert[first : first + model.mesh_vertnum[mesh]]
            return np.asarray(corners, dtype=float)
        size = np.array(model.geom_size[geom])
        if kind == KIND.mjGEOM_BOX:
            return np.asarray(CORNERS * size)
        return np.outer([-1.0, 1.0], [0.0, 0.0, size[1] * (kind == KIND.mjGEOM_CAPSULE)])

    def _velocity(self, data: Any, geom: int) -> Array:
        """Angular velocity [rad/s] and that of the centre [m/s] of a geom, shape (6,)."""
        velocity = np.zeros(6)
        mujoco.mj_objectVelocity(self.model, data, GEOM, geom, velocity, 0)
        return velocity

    def _placed(self, state: Array) -> Any:
        """The mjData for states within a step in this one."""
        put(self.inside, state)
        mujoco.mj_kinematics(self.model, self.inside)
        mujoco.mj_comPos(self.model, self.inside)
        mujoco.mj_comVel(self.model, self.inside)
        return self.inside

    def _speeds(self, data: Any, time: float) -> Speeds:
        """The speeds of an mjData at a time [s]; written out, as numpy's cross product takes
        several times as long for few geoms."""
        w0, w1, w2, v0, v1, v2 = data.cvel[self.bodies].T
        a0, a1, a2 = (data.geom_xpos - data.subtree_com[self.roots]).T
        x = v0 + w1 * a2 - w2 * a1
        y = v1 + w2 * a0 - w0 * a2
        z = v2 + w0 * a1 - w1 * a0
        spins = np.sqrt(w0 * w0 + w1 * w1 + w2 * w2)
        surfaces = np.sqrt(x * x + y * y + z * z) + self.radii * spins
        return Speeds(time, surfaces, float(spins.max(initial=0.0)))


def _leaves(one: Pair, other: Pair) -> Array:
    """The distance [m] by which each point of a pair leaves the line between two times, at most."""
    step = other.time - one.time
    moved = other.places - one.places
    early, late = step * one.velocities, step * other.velocities
    # h² times the acceleration of the cubic through both at its ends
    curves = (6.0 * moved - 4.0 * early - 2.0 * late, 6.0 * moved - 2.0 * early - 4.0 * late)
    return np.asarray(CURVED / 8.0 * np.maximum(*map(_lengths, curves)))


def _least(begin: Array, end: Array, leaves: Array) -> Array:
    """The least of begin + (end - begin) x - leaves x (1 - x) for x from 0 to 1, elementwise."""
    places = (begin - end + leaves) / np.maximum(2.0 * leaves, TINY)
    x = np.clip(places, 0.0, 1.0)
    return np.asarray(begin + (end - begin) * x - leaves * x * (1.0 - x))


def _lengths(rows: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", rows, rows)))


def _length(vector: Array) -> float:
    return math.sqrt(float(vector @ vector))
