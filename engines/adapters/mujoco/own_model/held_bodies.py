"""A user's bodies at rest on their contacts: their loads and rows for statics, and their creep."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.errors.contact_models.creep import CREEP_TIME, SoftRows, steady_creep
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import SoftPoint
from plumbob.analytic.systems.coulomb_statics import ContactRows, HeldLoads
from plumbob.engines.adapters.mujoco.model_fields import name_of
from plumbob.engines.adapters.mujoco.options import collected
from plumbob.engines.adapters.mujoco.own_model.corners import corners_of
from plumbob.engines.adapters.mujoco.own_model.model import start_data
from plumbob.engines.adapters.mujoco.own_model.places import actuator_moments
from plumbob.engines.adapters.mujoco.own_model.readings import pair_name
from plumbob.engines.adapters.mujoco.own_model.refusals import check_continuous
from plumbob.engines.adapters.mujoco.own_model.user_stepper import diverged
from plumbob.engines.adapters.mujoco.terms import CompiledSteps
from plumbob.engines.adapters.mujoco.user_file import user_model
from plumbob.engines.method import time_step
from plumbob.engines.own_holds import (
    FrictionOptions,
    HeldGroup,
    MeasuredCreep,
    RestingPlace,
)
from plumbob.engines.own_motion import NotCertifiable, Start

KINDS = mujoco.mjtConstraint
EQUALITY_ROW = int(KINDS.mjCNSTR_EQUALITY)
DRY = (int(KINDS.mjCNSTR_FRICTION_DOF), int(KINDS.mjCNSTR_FRICTION_TENDON))
LIMITED = (int(KINDS.mjCNSTR_LIMIT_JOINT), int(KINDS.mjCNSTR_LIMIT_TENDON))
# Largest gap that counts as none, as a fraction of the mean size of a body: places in a file are
# rounded.
TOUCHING_GAP = 1e-3
# [s] in which the creep is measured, again and again until it is steady: ten default time constants
# of a contact, so that a fast creep is measured before a finger is left
WINDOW = 0.2
# Relative change of the creep from one measurement to the next that counts as none
STEADY = 0.02
NO_CHANGE = 1e-9  # [m/s] change that counts as none at any creep
MOST_WINDOWS = 25  # number of measurements: 5 s for servos that give way slowly
SLIPS = 0.999  # ratio of a dry joint's force to its largest from which on the joint slips
# Largest ratio of the acceleration of settled bodies to the free one: the resolution of statics
SETTLED_WITHIN = 1e-3
WANDERED = 0.25  # ratio of displacement to size beyond which bodies have left their start
# Bounds of MuJoCo's solimp: smallest and largest impedance and midpoint
IMPEDANCES = (1e-4, 0.9999)
MOST_RUN_SECONDS = 5.0  # [s] processor time of a run
# Largest number of contacts of connected bodies: their linear programmes take about two seconds
MOST_CONTACTS = 100
CLOCK_PART = 0.1  # [s] of a run between two looks at the clock


def held_bodies(model: Any, start: Start, body: str | None) -> MujocoHeld:
    """Returns a user's `model` at rest at its `start`, with the named `body`, or all bodies that
    touch. Raises ParameterError and NotCertifiable."""
    model, name, start = user_model(model, start)
    time_step("model", model.opt.timestep, name)
    with collected():
        data = start_data(model, start)
        data.qvel[:] = 0.0
        mujoco.mj_forward(model, data)
        held = MujocoHeld(name, model, data, _number(model, body))
        if not model.nv:
            raise NotCertifiable("no body can move")
        if not np.isfinite(data.qacc_smooth).all():
            raise NotCertifiable("at its start something is not a number")
        if not (held.at_start.groups or (held.settled and held.settled.groups)):
            what = (
                f"{body} touches nothing" if body else "no body that can move touches anything"
            )
            raise NotCertifiable(f"{what} at the start, or where it comes to rest")
        return held


def _number(model: Any, body: str | None) -> int | None:
    """Returns the number of a body that can move; None without a name. Raises ParameterError."""
    if body is None:
        return None
    movable = np.flatnonzero(model.body_treeid >= 0).tolist()
    names = {name_of(model, "body", number): number for number in movable}
    if body not in names:
        offered = ", ".join(list(names)[:10]) or "none: no body can move"
        raise ParameterError("holds body", body, f"a body that can move: {offered}")
    return names[body]


@dataclass(frozen=True)
class MujocoHeld(CompiledSteps):
    """A user's bodies at rest."""

    name: str
    model: Any  # mjModel as it is stepped
    start: Any  # mjData at the start, at rest
    body: int | None  # number of the body that is asked for; None: all that touch

    @property
    def options(self) -> FrictionOptions:
        """The options that decide how fast bodies creep."""
        option = self.model.opt
        cone = ("pyramidal", "elliptic")[option.cone]
        return FrictionOptions(cone, float(option.impratio), int(option.noslip_iterations))

    def with_options(self, options: FrictionOptions) -> MujocoHeld:
        """Returns the same bodies under other options."""
        model = copy.copy(self.model)
        model.opt.cone = ("pyramidal", "elliptic").index(options.cone)
        model.opt.impratio = options.impratio
        model.opt.noslip_iterations = options.noslip_iterations
        return replace(self, model=model)

    @property
    def refusal(self) -> str:
        """The reason why an audit of the motion refuses the model; empty if it does not."""
        try:
            check_continuous(self.model)
        except NotCertifiable as why:
            return str(why)
        return ""

    @cached_property
    def at_start(self) -> RestingPlace:
        """The bodies at the start."""
        return RestingPlace(tuple(self._groups(self.start)))

    @cached_property
    def _rested(self) -> Any:
        """The mjData after the time in which the creep becomes steady; None if the run diverges."""
        return self._creeping[0]

    @cached_property
    def _creeping(self) -> tuple[Any, float, bool, float]:
        """The mjData of bodies that creep, their speed [m/s], whether it is steady, and the
        processor time [s] of a step; None and an infinite speed if the run diverges."""
        data = copy.copy(self.start)
        speeds = list[float]()
        begin = time.thread_time()
        for _ in range(MOST_WINDOWS):
            before = copy.copy(data)
            if not self._run(data, WINDOW):
                return None, math.inf, False, math.nan
            speeds.append(self._moved(before, data)[0] / (data.time - before.time))
            # The first measurement has the way into the contacts.
            change = abs(speeds[-1] - speeds[-2]) if len(speeds) > 2 else math.inf
            late = time.thread_time() - begin > MOST_RUN_SECONDS
            if late or change <= STEADY * speeds[-1] + NO_CHANGE:
                break
        steps = (data.time - self.start.time) / self.step
        seconds = (time.thread_time() - begin) / steps
        return data, speeds[-1], change <= STEADY * speeds[-1] + NO_CHANGE, seconds

    @cached_property
    def settled(self) -> RestingPlace | None:
        """The bodies where they have settled under the model's own steps; None if they do not come
        to rest, or leave their start."""
        data = self._rested
        if data is None:
            return None
        moved, size = self._moved(self.start, data)
        # The velocities of creep belong to the forces of friction.
        mujoco.mj_forward(self.model, data)
        left = np.linalg.norm(_scaled(self.model, data, data.qacc))
        free = np.linalg.norm(_scaled(self.model, data, data.qacc_smooth))
        if moved > WANDERED * size or left > SETTLED_WITHIN * free:
            return None
        return RestingPlace(tuple(self._groups(data, settled=True)), moved)

    def _run(self, data: Any, duration: float) -> bool:
        """Steps `data` for a duration [s], and returns whether it stays finite and is in time."""
        steps = max(1, round(duration / self.step))
        part = max(1, round(CLOCK_PART / self.step))
        begin = time.thread_time()
        with collected():
            for first in range(0, steps, part):
                mujoco.mj_step(self.model, data, min(part, steps - first))
                if diverged(data) or time.thread_time() - begin > MOST_RUN_SECONDS:
                    return False
        return True

    def _moved(self, first: Any, second: Any) -> tuple[float, float]:
        """Returns the largest displacement [m] of a corner of the judged bodies between two mjData,
        and the largest extent [m] of a body."""
        places = [self._corners(data.qpos) for data in (first, second)]
        extents = [
            np.ptp(places[0][self._corner_bodies == b], axis=0).max() for b in self._bodies
        ]
        moved = np.linalg.norm(places[1] - places[0], axis=1)
        judged = np.isin(self._corner_bodies, self._bodies)
        return float(moved[judged].max(initial=0.0)), float(max(extents, default=0.0))

    @cached_property
    def _bodies(self) -> list[int]:
        """The numbers of the bodies whose displacement counts: the one that is asked for, or those
        that touch something at the start, or all if none do."""
        if self.body is not None:
            return [self.body]
        names = {name for group in self.at_start.groups for name in group.bodies}
        movable = np.flatnonzero(self.model.body_treeid >= 0).tolist()
        chosen = [b for b in movable if name_of(self.model, "body", b) in names]
        return chosen or movable

    @cached_property
    def _corner_points(self) -> tuple[Array, Array]:
        """The corner points of the bodies in their own frames [m], and their bodies."""
        return corners_of(self.model)

    @property
    def _corner_bodies(self) -> Array:
        """The number of the body of each corner point."""
        return self._corner_points[1]

    def _corners(self, qpos: Array) -> Array:
        """Returns the corner points [m] at the positions `qpos`, shape (corners, 3)."""
        data = copy.copy(self.start)
        data.qpos[:] = qpos
        mujoco.mj_kinematics(self.model, data)
        offsets, bodies = self._corner_points
        turns = data.xmat.reshape(-1, 3, 3)[bodies]
        return np.asarray(data.xpos[bodies] + np.einsum("kij,kj->ki", turns, offsets))

    def creep(self, durations: tuple[float, ...] = ()) -> MeasuredCreep:
        """Returns how fast and how far the bodies creep after they have settled, over some
        `durations` [s] in ascending order, as far as there is time to run them."""
        first, speed, steady, seconds = self._creeping
        if first is None:
            return MeasuredCreep(math.inf, False, math.nan, {}, math.nan)
        data = copy.copy(first)
        depth = -float(data.contact.dist.min(initial=0.0))
        distances = dict[float, float]()
        for duration in durations:
            if not self._run(data, duration + first.time - data.time):
                break
            distances[duration] = self._moved(first, data)[0]
        return MeasuredCreep(speed, steady, depth, distances, seconds)

    def predicted_creep(self) -> float | None:
        """Returns the speed [m/s] of the fastest corner that theory predicts for the loads of the
        contacts after the bodies have settled; None if friction does not balance the loads."""
        if self._rested is None:
            return None
        data = copy.copy(self._rested)
        mujoco.mj_forward(self.model, data)
        contacts = tuple(self._soft_rows(data))
        if not contacts:
            return None
        held, dry_resistance, dry_force = self._held_rows(data)
        velocity = steady_creep(
            contacts,
            data.qfrc_smooth + dry_force,
            held,
            _joint_resistance(self.model, data) + dry_resistance,
            self._safe_step,
        )
        if velocity is None:
            return None
        positions = np.array(data.qpos)
        mujoco.mj_integratePos(self.model, positions, velocity, 1.0)
        moved = copy.copy(data)
        moved.qpos[:] = positions
        return self._moved(data, moved)[0]

    @property
    def _safe_step(self) -> float:
        """The step [s] to which refsafe clamps time constants; 0 if it is off."""
        off = self.model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_REFSAFE
        return 0.0 if off else self.step

    def _elliptic(self, data: Any, gap: float = 0.0) -> tuple[Any, Any, Array]:
        """Returns a copy of the model with elliptic cones, its mjData in the state of `data`, and
        the rows of its constraints, shape (rows, nv). Geoms touch up to a `gap` [m]."""
        model = copy.copy(self.model)
        model.geom_margin += gap
        model.pair_margin += gap
        model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        other = copy.copy(data)
        mujoco.mj_forward(model, other)
        return model, other, np.array(other.efc_J).reshape(-1, model.nv)[: other.nefc]

    def _soft_rows(self, data: Any) -> Iterator[SoftRows]:
        """Yields the loaded contacts of a state for the theory of creep."""
        _, elliptic, rows = self._elliptic(data)
        force = np.zeros(6)
        for number, contact in enumerate(data.contact):
            mujoco.mj_contactForce(self.model, data, number, force)
            first = int(elliptic.contact.efc_address[number])
            if first < 0 or force[0] <= 0.0:
                continue
            yield SoftRows(
                rows=rows[first : first + contact.dim],
                friction=np.array(contact.friction[: contact.dim - 1]),
                load=float(force[0]),
                weight=_weight(elliptic, first),
                point=self._soft_point(contact),
                friction_damping=self._friction_damping(contact),
            )

    def _soft_point(self, contact: Any) -> SoftPoint:
        """Returns the regularisation of a contact."""
        option = self.options
        solref, solimp = contact.solref.tolist(), contact.solimp.tolist()
        least, most = (float(np.clip(d, *IMPEDANCES)) for d in solimp[:2])
        if solimp[2] <= mujoco.mjMINVAL:
            least = most = (least + most) / 2.0
        return SoftPoint(
            time_constant=solref[0],
            damping_ratio=solref[1],
            impedance=(least, most),
            width=max(solimp[2], mujoco.mjMINVAL),
            ratio=math.inf if option.noslip_iterations else option.impratio,
            pyramidal=option.cone == "pyramidal",
            midpoint=float(np.clip(solimp[3], *IMPEDANCES)),
            power=max(1.0, solimp[4]),
            direct=None if solref[0] > 0.0 else (-solref[0], -solref[1]),
        )

    def _friction_damping(self, contact: Any) -> float | None:
        """Returns the damping [1/s] that a contact's solreffriction sets; None if it sets none."""
        time_constant, second = contact.solreffriction.tolist()
        if not (time_constant or second) or self.options.cone == "pyramidal":
            return None
        most = float(np.clip(contact.solimp[1], *IMPEDANCES))
        if time_constant > 0.0:
            return float(2.0 / (most * max(time_constant, 2.0 * self._safe_step)))
        return float(-second / most)

    def _held_rows(self, data: Any) -> tuple[Array, Array, Array]:
        """Returns what holds joints where bodies creep: the rows of velocities that are 0, shape
        (n, nv), of equalities and of limits that push; the resistance of dry joints that stick,
        shape (nv, nv); and the force of dry joints that slip, shape (nv,)."""
        _, elliptic, rows = self._elliptic(data)
        kinds, forces = np.array(elliptic.efc_type), np.array(elliptic.efc_force)
        held = (kinds == EQUALITY_ROW) | (np.isin(kinds, LIMITED) & (forces != 0.0))
        dry = np.isin(kinds, DRY)
        slips = dry & (np.abs(forces) >= SLIPS * np.array(elliptic.efc_frictionloss))
        sticks = rows[dry & ~slips]
        # A dry joint that sticks has a row with a damping b and a softness R: it drifts at R F/b.
        stiff = np.array(elliptic.efc_KBIP)[:, 1] / np.array(elliptic.efc_R)
        resistance = sticks.T @ (stiff[dry & ~slips, None] * sticks)
        return rows[held], resistance, forces[slips] @ rows[slips]

    def _groups(self, data: Any, settled: bool = False) -> Iterator[HeldGroup]:
        """Yields the groups of bodies that touch something in a state, or the group of the body
        that is asked for. The small accelerations that are left where bodies have settled are no
        part of their loads."""
        gap = TOUCHING_GAP * float(self.model.stat.meansize)
        model, elliptic, rows = self._elliptic(data, gap)
        load = np.array(elliptic.qfrc_smooth)
        inertia = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, elliptic, inertia)
        if settled:
            load -= inertia @ data.qacc
        for trees in _connected_trees(model, rows):
            if self.body is not None and model.body_treeid[self.body] not in trees:
                continue
            dofs = np.flatnonzero(np.isin(model.dof_treeid, list(trees)))
            group = _Group(model, elliptic, rows[:, dofs])
            contacts = tuple(group.contacts())
            if len(contacts) > MOST_CONTACTS:
                raise NotCertifiable(
                    f"{len(contacts)} contacts connect its bodies, more than {MOST_CONTACTS}"
                )
            if contacts:
                yield HeldGroup(
                    bodies=group.bodies(trees),
                    loads=HeldLoads(
                        inertia=inertia[np.ix_(dofs, dofs)],
                        load=load[dofs],
                        contacts=contacts,
                        equalities=group.of_kinds((EQUALITY_ROW,))[0],
                        stops=group.of_kinds(LIMITED)[0],
                        dry=group.of_kinds(DRY)[0],
                        dry_limits=group.of_kinds(DRY)[1],
                        actuation=np.array(elliptic.qfrc_actuator)[dofs],
                    ),
                    pairs=group.pairs,
                    coefficients=tuple(float(c.friction.max(initial=0.0)) for c in contacts),
                )


class _Group:
    """The constraints of some degrees of freedom of a model with elliptic cones."""

    def __init__(self, model: Any, data: Any, rows: Array) -> None:
        """`rows` are the rows of all constraints in these degrees of freedom."""
        self.model, self.data, self.rows = model, data, rows
        self.kinds = np.array(data.efc_type)
        self.numbers = [
            number
            for number, contact in enumerate(data.contact)
            if contact.efc_address >= 0 and rows[contact.efc_address].any()
        ]

    @property
    def pairs(self) -> tuple[str, ...]:
        """The names of the two geoms of each contact."""
        return tuple(pair_name(self.model, self.data.contact[k].geom) for k in self.numbers)

    def bodies(self, trees: set[int]) -> tuple[str, ...]:
        """Returns the names of the bodies of some trees."""
        chosen = np.flatnonzero(np.isin(self.model.body_treeid, list(trees)))
        return tuple(name_of(self.model, "body", number) for number in chosen.tolist())

    def contacts(self) -> Iterator[ContactRows]:
        """Yields the contacts, numbered by the pair of bodies that they are between. Each geom of
        the world counts as a body."""
        pairs = dict[tuple[int, ...], int]()
        bodies = self.model.body_weldid[self.model.geom_bodyid]
        for number in self.numbers:
            contact = self.data.contact[number]
            geoms = contact.geom.tolist()
            key = tuple(sorted(int(bodies[g]) or -1 - g for g in geoms))
            first = int(contact.efc_address)
            yield ContactRows(
                rows=self.rows[first : first + contact.dim],
                friction=np.array(contact.friction[: contact.dim - 1]),
                pair=pairs.setdefault(key, len(pairs)),
            )

    def of_kinds(self, kinds: tuple[int, ...]) -> tuple[Array, Array]:
        """Returns the rows of some kinds of constraints, and their largest dry friction."""
        chosen = np.isin(self.kinds, kinds) & self.rows.any(axis=1)
        return self.rows[chosen], np.array(self.data.efc_frictionloss)[chosen]


def _connected_trees(model: Any, rows: Array) -> list[set[int]]:
    """Returns the sets of kinematic trees that constraints connect."""
    sets = [{tree} for tree in range(model.ntree)]
    for row in rows:
        trees = set(np.unique(model.dof_treeid[np.flatnonzero(row)]).tolist())
        joined = set[int]().union(*(s for s in sets if s & trees))
        if joined:
            sets = [s for s in sets if not s & trees] + [joined]
    return sets


def _weight(data: Any, row: int) -> float:
    """Returns the inverse mass [1/kg] by which MuJoCo regularises a row: R = (1 - d)/d times it."""
    impedance = float(data.efc_KBIP[row, 2])
    return float(data.efc_R[row]) * impedance / (1.0 - impedance)


def _scaled(model: Any, data: Any, acceleration: Array) -> Array:
    """Returns an acceleration in coordinates whose norm is that of the inertia."""
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, inertia)
    return np.asarray(np.linalg.cholesky(inertia).T @ acceleration)


def _joint_resistance(model: Any, data: Any) -> Array:
    """Returns what resists slow velocities of joints, shape (nv, nv): the damping, and the
    stiffness of springs and position servos times CREEP_TIME, as after a slow motion of this
    duration."""
    springs = np.ravel(model.jnt_stiffness)[model.dof_jntid]
    moments = actuator_moments(model, data)
    servos = -model.actuator_biasprm[:, 1] * CREEP_TIME - model.actuator_biasprm[:, 2]
    resistance = np.diag(springs * CREEP_TIME + np.ravel(model.dof_damping)[: model.nv])
    return np.asarray(resistance + moments.T @ (np.maximum(servos, 0.0)[:, None] * moments))
