"""Finds touches of two geoms within a step of an integration that neither end of the step shows.

An adaptive method accepts a step by what it finds at its stages. If a ball is before a card at one
stage and behind the card at the next one, the method has met nothing. Conservative advancement
excludes such a touch: two convex geoms a distance d apart do not touch before they approach by d.

Two bounds say how far they approach in a step of length h.

1. A point of a geom moves at |v| + |w| r at most, for the velocity v of the geom's centre, its
   angular velocity w and its radius r. The bound is PATH h times the larger of this speed at the
   two ends. A step that keeps a tolerance of 1e-8 is some 1.5 rad of an oscillation at most, whose
   speed at its middle is 1/cos(0.75) = 1.37 times that at the ends. The paths of the geoms are
   summed over steps: a pair is measured again only when the sum has used up its distance.
2. If the first bound does not exclude a touch, the second one follows points of the second geom in
   the axes of the first, where a common motion vanishes. The points are the centre of a sphere, the
   ends of a capsule, the corners of a box or a mesh. Along the normal n of the shortest connection,
   fixed in these axes, a point p goes from n·p at one end to n·p at the other. It leaves the line
   between them by a parabola, h²/8 times its largest acceleration at most. CURVED times the larger
   end acceleration of the cubic through the places and velocities at both ends bounds this
   acceleration. A cylinder or ellipsoid has its centre as its only point, and its rotation brings
   its surface nearer by h r |n × w|, rotation about an axis of symmetry left out.

If neither bound excludes a touch, the search evaluates the motion at the middle of the step and
goes on in both halves. The motion within a step is the polynomial of the method. If the polynomial
leaves the second bound, some stages of the method have met something, and the step is halved.
Distances are those of `mj_geomDistance`, which is exact to 2e-10 m for convex geoms; like MuJoCo's
collisions it takes the convex hull of a mesh.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.colliding_pairs import colliding_pairs
from plumbob.engines.adapters.mujoco.own_model.readings import pair_name
from plumbob.engines.adapters.mujoco.solids import CORNERS, mesh_vertices
from plumbob.engines.adapters.mujoco.terms import put
from plumbob.engines.own_motion import NotCertifiable

GEOM = mujoco.mjtObj.mjOBJ_GEOM
KIND = mujoco.mjtGeom
SMOOTH = (int(KIND.mjGEOM_CYLINDER), int(KIND.mjGEOM_ELLIPSOID))
# Kinds that are symmetric about their third axis
SYMMETRIC = (KIND.mjGEOM_SPHERE, KIND.mjGEOM_CAPSULE, KIND.mjGEOM_CYLINDER)
# Ratio of the largest speed within a step to the larger speed at its ends, at most: see above
PATH = 1.5
CURVED = 2.0  # ratio of accelerations, likewise
TURNED = 0.5  # [rad] largest turn within a step at which its ends bound the motion between them
SHALLOW = 1e-9  # [m] depth of a touch that counts as none: distances are exact to less
LOOKS = 4000  # most states within a step that the search evaluates
TINY = np.finfo(float).tiny
FAR = 1e3  # [m] largest distance that is measured
BISECTIONS = 20  # halvings of the time between a state that touches and one that does not
Motion = Callable[[float], Array]
"""Returns the state at a time [s] within a step."""


@dataclass(frozen=True)
class Touch:
    """Times [s] at which a touch of two geoms begins and ends. If a step turns too far to tell,
    both are its middle."""

    begins: float
    ends: float


@dataclass(frozen=True)
class PairState:
    """Two geoms at a time, and the motion of points of the second in the axes of the first."""

    time: float  # [s]
    distance: float  # [m] distance less the margin; if it is not positive, the geoms touch
    normal: Array  # from the first to the second
    places: Array  # [m] of the points, shape (n, 3)
    velocities: Array  # [m/s] of the points, shape (n, 3)
    spin: Array  # [rad/s] of the second, without the spin about an axis of symmetry
    turning: float  # [rad/s] the larger of |spin| and the angular speed of the axes


@dataclass(frozen=True)
class Speeds:
    """The largest speed [m/s] of the surface of each geom, shape (geoms,), and the largest angular
    speed [rad/s] of all geoms, at a time [s]."""

    time: float
    surfaces: Array
    spin: float


class HiddenTouches:
    """Searches each step of an integration for touches that neither end of the step shows.

    The mjData `current` holds the state that the integration has reached. States within a step are
    evaluated in the mjData `inside`. The integration begins at the state `start`."""

    def __init__(self, model: Any, current: Any, inside: Any, start: Array) -> None:
        self.model, self.current, self.inside = model, current, inside
        pairs, margins = colliding_pairs(model)
        self.margins: list[float] = margins.tolist()
        kinds = model.geom_type
        self.radii = np.array(model.geom_rbound)
        # Displacement of a surface by a rotation of 1 rad [m]. The second geom of a pair is never a
        # plane.
        levers = np.where(kinds == KIND.mjGEOM_PLANE, np.inf, self.radii)
        self.levers = np.where(kinds == KIND.mjGEOM_SPHERE, 0.0, levers)
        self.symmetric = np.isin(kinds, SYMMETRIC)
        swapped = self.levers[pairs[:, 0]] < self.levers[pairs[:, 1]]
        ordered = np.where(swapped[:, None], pairs[:, ::-1], pairs)
        self.pairs: list[list[int]] = ordered.tolist()
        self.first, self.second = np.ascontiguousarray(ordered.T)
        self.bodies = np.array(model.geom_bodyid)
        self.roots = model.body_rootid[self.bodies]
        self.travelled = np.zeros(model.ngeom)  # [m] bound on the path of each geom's surface
        # Paths [m] of both geoms together up to which their distance need not be measured again
        self.limits = np.zeros(len(pairs))
        self.touching = np.zeros(len(pairs), bool)
        self.last = self._speeds(self._placed(start), 0.0)

    def within(self, time: float, dense: Callable[[], Motion]) -> Touch | None:
        """Returns a touch that the step up to `time` [s] passes over, or None. `dense` returns the
        motion within the step. After a touch the step is to be repeated in parts; after None the
        next step begins at `time`. The distance of a pair is computed again only once its two
        surfaces have travelled as far together as they were apart. Raises NotCertifiable if geoms
        pass so close that nobody can tell whether they touch."""
        if not self.limits.size:
            return None
        last, now = self.last, self._speeds(self.current, time)
        paths = PATH * (time - last.time) * np.maximum(last.surfaces, now.surfaces)
        travelled = self.travelled + paths
        used = travelled[self.first] + travelled[self.second]
        due = np.flatnonzero(used >= self.limits)
        distances = np.array([self._distance(self.current, row)[0] for row in due.tolist()])
        near = distances <= paths[self.first[due]] + paths[self.second[due]]
        touch = self._touch_of(due[near].tolist(), distances[near].tolist(), now, dense)
        if touch is None:
            self.touching[due] = distances <= SHALLOW
            self.limits[due] = used[due] + np.maximum(distances, 0.0)
            self.travelled, self.last = travelled, now
        return touch

    def _touch_of(
        self,
        rows: Sequence[int],
        distances: Sequence[float],
        now: Speeds,
        dense: Callable[[], Motion],
    ) -> Touch | None:
        """Returns the touch of the first row, in the order given, whose pair touches in the step up
        to `now`; `distances` [m] are those at the end of the step. None if no pair touches."""
        start, end = self.last.time, now.time
        turns = (end - start) * max(self.last.spin, now.spin) > TURNED
        motion: Motion | None = None
        for row, distance in zip(rows, distances, strict=True):
            if distance <= SHALLOW or self.touching[row]:
                # The pair touches at an end of the step, where the integration sees it. In a step
                # that turns far, a second touch may be hidden.
                middle = (start + end) / 2.0
                touch = Touch(middle, middle) if turns else None
            else:
                motion = motion or dense()
                touch = self._touch_between(row, motion, start, end)
            if touch is not None:
                return touch
        return None

    def _touch_between(
        self, row: int, motion: Motion, start: float, end: float
    ) -> Touch | None:
        """Returns a touch of a pair between two times [s], at which it is clear; None if there is
        no touch."""
        spans = [(self._pair_at(row, motion, start), self._pair_at(row, motion, end))]
        for _ in range(LOOKS):
            if not spans:
                return None
            early, late = spans.pop()
            if self._cannot_touch(row, early, late):
                continue
            middle = self._pair_at(row, motion, (early.time + late.time) / 2.0)
            if middle.distance <= 0.0:
                begins = self._edge(row, motion, early.time, middle.time)
                ends = self._edge(row, motion, late.time, middle.time)
                return Touch(begins, ends)
            turned = (late.time - early.time) * max(early.turning, late.turning)
            off_line = _lengths(middle.places - (early.places + late.places) / 2.0)
            if turned <= TURNED and (off_line > _departures(early, late) + SHALLOW).any():
                # Some stages of the method have met something: the polynomial is not the motion.
                return Touch(middle.time, middle.time)
            spans += [(middle, late), (early, middle)]
        raise NotCertifiable(
            f"{pair_name(self.model, self.pairs[row])} pass too close to tell whether "
            f"they touch, from {spans[-1][0].time:.4g} s on"
        )

    def _edge(self, row: int, motion: Motion, clear: float, touching: float) -> float:
        """Returns the time [s] at which a touch begins or ends, rounded into the touch. The pair is
        clear at the time `clear` [s] and touches at the time `touching` [s]."""
        for _ in range(BISECTIONS):
            middle = (clear + touching) / 2.0
            touches = self._pair_at(row, motion, middle).distance <= 0.0
            clear, touching = (clear, middle) if touches else (middle, touching)
        return touching

    def _cannot_touch(self, row: int, early: PairState, late: PairState) -> bool:
        """Whether the bounds exclude a touch between two states of a pair, clear in both. The first
        bound is tried in the axes of the first geom, then the second bound from either end."""
        kind = int(self.model.geom_type[self.second[row]])
        lever = float(self.levers[self.second[row]]) if kind in SMOOTH else 0.0
        step = late.time - early.time
        ends = (early, late)
        speeds = [_lengths(pair.velocities).max() + lever * _length(pair.spin) for pair in ends]
        if early.distance + late.distance + SHALLOW > PATH * step * max(speeds):
            return True
        if step * max(early.turning, late.turning) > TURNED:
            return False
        return any(
            _least_distance(end, other, lever) > -SHALLOW for end, other in (ends, ends[::-1])
        )

    def _distance(self, data: Any, row: int) -> tuple[float, Array]:
        """Returns the distance [m] of a pair less its margin, and the shortest connection [m] from
        its first geom to its second, shape (3,)."""
        ends = np.zeros(6)
        first, second = self.pairs[row]
        distance = mujoco.mj_geomDistance(self.model, data, first, second, FAR, ends)
        return distance - self.margins[row], ends[3:] - ends[:3]

    def _pair_at(self, row: int, motion: Motion, time: float) -> PairState:
        """Returns the state of a pair at a time [s] within a step."""
        data = self._placed(motion(time))
        distance, connection = self._distance(data, row)
        first, second = self.pairs[row]
        axes = data.geom_xmat[first].reshape(3, 3)
        turn, start = self._velocities(data, first)
        spin, velocity = self._velocities(data, second)
        arms = self._points(second) @ data.geom_xmat[second].reshape(3, 3).T
        places = data.geom_xpos[second] - data.geom_xpos[first] + arms
        velocities = velocity - start + np.cross(spin, arms) - np.cross(turn, places)
        spin = spin - turn
        if self.symmetric[second]:
            axis = data.geom_xmat[second][2::3]
            spin = spin - (spin @ axis) * axis
        return PairState(
            time=time,
            distance=distance,
            normal=connection @ axes / _length(connection),
            places=places @ axes,
            velocities=velocities @ axes,
            spin=spin @ axes,
            turning=max(_length(spin), _length(turn)),
        )

    def _points(self, geom: int) -> Array:
        """Returns points [m] of a geom in its own axes, shape (n, 3). Their convex hull, thickened
        by a radius, is the geom. A cylinder or an ellipsoid has its centre only."""
        model = self.model
        kind = model.geom_type[geom]
        if kind == KIND.mjGEOM_MESH:
            return mesh_vertices(model, geom)
        size = np.array(model.geom_size[geom])
        if kind == KIND.mjGEOM_BOX:
            return np.asarray(CORNERS * size)
        return np.outer([-1.0, 1.0], [0.0, 0.0, size[1] * (kind == KIND.mjGEOM_CAPSULE)])

    def _velocities(self, data: Any, geom: int) -> tuple[Array, Array]:
        """Returns the angular velocity [rad/s] of a geom and the velocity [m/s] of its centre,
        shape (3,) each."""
        velocity = np.zeros(6)
        mujoco.mj_objectVelocity(self.model, data, GEOM, geom, velocity, 0)
        return velocity[:3], velocity[3:]

    def _placed(self, state: Array) -> Any:
        """Returns the mjData `inside`, set to a state."""
        put(self.inside, state)
        mujoco.mj_kinematics(self.model, self.inside)
        mujoco.mj_comPos(self.model, self.inside)
        mujoco.mj_comVel(self.model, self.inside)
        return self.inside

    def _speeds(self, data: Any, time: float) -> Speeds:
        """Returns the speeds of an mjData at a time [s]. The cross product is written out: numpy's
        takes several times as long for few geoms."""
        w0, w1, w2, v0, v1, v2 = data.cvel[self.bodies].T
        a0, a1, a2 = (data.geom_xpos - data.subtree_com[self.roots]).T
        x = v0 + w1 * a2 - w2 * a1
        y = v1 + w2 * a0 - w0 * a2
        z = v2 + w0 * a1 - w1 * a0
        spins = np.sqrt(w0 * w0 + w1 * w1 + w2 * w2)
        surfaces = np.sqrt(x * x + y * y + z * z) + self.radii * spins
        return Speeds(time, surfaces, float(spins.max(initial=0.0)))


def _least_distance(end: PairState, other: PairState, lever: float) -> float:
    """Returns the second bound on the distances [m] of the points of a pair from the plane of
    contact at one `end` of a step, on the way to the `other` end. A rotation of 1 rad brings the
    surface nearer by `lever` [m]."""
    normal = end.normal
    spins = [_length(np.cross(normal, pair.spin)) for pair in (end, other)]
    spin = max(spins) + _length(other.spin - end.spin)
    along = end.places @ normal
    distances = end.distance + along - along.min()
    approach = abs(other.time - end.time) * lever * spin
    other_distances = distances + (other.places - end.places) @ normal - approach
    early, late = sorted((end, other), key=lambda pair: pair.time)
    curves = 4.0 * _departures(early, late)
    return float(_least_on_parabola(distances, other_distances, curves).min())


def _departures(early: PairState, late: PairState) -> Array:
    """Returns bounds on the distances [m] by which the points of a pair leave the straight lines
    between two states, shape (n,)."""
    step = late.time - early.time
    moved = late.places - early.places
    start, end = step * early.velocities, step * late.velocities
    # Both are h² times the acceleration of the cubic through both states, at one end each.
    curves = (6.0 * moved - 4.0 * start - 2.0 * end, 6.0 * moved - 2.0 * start - 4.0 * end)
    return np.asarray(CURVED / 8.0 * np.maximum(*map(_lengths, curves)))


def _least_on_parabola(begin: Array, end: Array, curves: Array) -> Array:
    """Returns the least value of begin + (end - begin) x - curves x (1 - x) for x from 0 to 1,
    elementwise."""
    places = (begin - end + curves) / np.maximum(2.0 * curves, TINY)
    x = np.clip(places, 0.0, 1.0)
    return np.asarray(begin + (end - begin) * x - curves * x * (1.0 - x))


def _lengths(rows: Array) -> Array:
    """Returns the lengths of the rows of a matrix."""
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", rows, rows)))


def _length(vector: Array) -> float:
    """Returns the length of a vector."""
    return math.sqrt(float(vector @ vector))
