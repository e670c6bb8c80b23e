"""Makes the mechanism of a compiled MuJoCo model, and names parts that a mechanism cannot
express."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.colliding_pairs import colliding_pairs
from plumbob.engines.adapters.mujoco.model_fields import name_with_kind
from plumbob.engines.mechanism import (
    Actuator,
    Body,
    Joint,
    JointKind,
    Loop,
    LoopKind,
    Mechanism,
    NotExpressed,
    Shape,
    ShapeKind,
    Term,
    Touch,
)
from plumbob.engines.peer_model import rotation

GEOM, EQUALITY = mujoco.mjtGeom, mujoco.mjtEq
BITS = mujoco.mjtDisableBit
JOINT_KINDS = MappingProxyType[int, JointKind](
    {
        int(mujoco.mjtJoint.mjJNT_HINGE): "hinge",
        int(mujoco.mjtJoint.mjJNT_SLIDE): "slide",
        int(mujoco.mjtJoint.mjJNT_BALL): "ball",
        int(mujoco.mjtJoint.mjJNT_FREE): "free",
    }
)
LOOP_KINDS = MappingProxyType[int, LoopKind](
    {int(EQUALITY.mjEQ_CONNECT): "connect", int(EQUALITY.mjEQ_WELD): "weld"}
)
SHAPE_KINDS = MappingProxyType[int, ShapeKind](
    {
        int(GEOM.mjGEOM_SPHERE): "sphere",
        int(GEOM.mjGEOM_CAPSULE): "capsule",
        int(GEOM.mjGEOM_BOX): "box",
        int(GEOM.mjGEOM_CYLINDER): "cylinder",
        int(GEOM.mjGEOM_ELLIPSOID): "ellipsoid",
        int(GEOM.mjGEOM_PLANE): "plane",
        int(GEOM.mjGEOM_MESH): "hull",
    }
)
SIZES = MappingProxyType({"sphere": 1, "capsule": 2, "cylinder": 2, "plane": 0, "hull": 0})
FIXED, AFFINE = int(mujoco.mjtGain.mjGAIN_FIXED), int(mujoco.mjtBias.mjBIAS_AFFINE)
ONE_DEGREE = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
SITE = int(mujoco.mjtObj.mjOBJ_SITE)
Ends = tuple[tuple[int, int], tuple[Array, Array], Array]
"""Two bodies, a point in the frame of each [m], and the attitude of the second body in the
first."""


def compiled_mechanism(model: Any) -> Mechanism:
    """The mechanism of a compiled model. If the model disables a stage, its numbers are zero in the
    mechanism: gravity, stiffness, damping."""
    loops, other_equalities = _loops(model)
    actuators, other_actuators = _actuators(model)
    pairs = colliding_pairs(model)[0].tolist()
    numbers = {geom: number for number, geom in enumerate(sorted(set(chain(*pairs))))}
    off = model.opt.disableflags
    return Mechanism(
        bodies=tuple(_body(model, i) for i in range(model.nbody)),
        joints=tuple(_joint(model, i) for i in range(model.njnt)),
        loops=loops,
        shapes=tuple(_shape(model, geom) for geom in numbers),
        touching=tuple(_touching(model, pairs, numbers)),
        actuators=actuators,
        gravity=np.zeros(3) if off & BITS.mjDSBL_GRAVITY else np.array(model.opt.gravity),
        not_expressed=(*other_equalities, *other_actuators, *_not_expressed(model)),
    )


def _body(model: Any, number: int) -> Body:
    """The record of a body of a model."""
    turn = rotation(model.body_iquat[number])
    return Body(
        name=model.body(number).name,
        parent=int(model.body_parentid[number]),
        place=np.array(model.body_pos[number]),
        attitude=np.array(model.body_quat[number]),
        mass=float(model.body_mass[number]),
        centre=np.array(model.body_ipos[number]),
        inertia=turn @ np.diag(model.body_inertia[number]) @ turn.T,
        carried=float(model.body_gravcomp[number]),
    )


def _joint(model: Any, number: int) -> Joint:
    """The record of a joint of a model."""
    kind = JOINT_KINDS[int(model.jnt_type[number])]
    first = model.jnt_qposadr[number]
    coordinates = slice(first, first + {"ball": 4, "free": 7}.get(kind, 1))
    degree = model.jnt_dofadr[number]
    degrees = slice(degree, degree + {"ball": 3, "free": 6}.get(kind, 1))
    off = model.opt.disableflags
    stiffness = 0.0 if off & BITS.mjDSBL_SPRING else float(model.jnt_stiffness[number])
    damped = not off & BITS.mjDSBL_DAMPER
    return Joint(
        name=model.joint(number).name,
        kind=kind,
        body=int(model.jnt_bodyid[number]),
        axis=np.array(model.jnt_axis[number]),
        place=np.array(model.jnt_pos[number]),
        reference=np.array(model.qpos0[coordinates]),
        stiffness=stiffness,
        rest=np.array(model.qpos_spring[coordinates]),
        damping=np.array(model.dof_damping[degrees]) * damped,
        armature=np.array(model.dof_armature[degrees]),
        friction_loss=np.array(model.dof_frictionloss[degrees]),
        limits=_range(model.jnt_limited[number], model.jnt_range[number]),
        force_range=_range(model.jnt_actfrclimited[number], model.jnt_actfrcrange[number]),
    )


def _range(limited: Any, values: Array) -> tuple[float, float] | None:
    """Two limits, or None if there is no limit."""
    return (float(values[0]), float(values[1])) if limited else None


def _loops(model: Any) -> tuple[tuple[Loop, ...], tuple[NotExpressed, ...]]:
    """The loops of a model, and its equality constraints of other kinds."""
    loops = list[Loop]()
    others = list[NotExpressed]()
    for number in np.flatnonzero(model.eq_active0).tolist():
        kind = LOOP_KINDS.get(int(model.eq_type[number]))
        if kind is None:
            others.append(
                NotExpressed(name_with_kind(model, "equality", number), ("constraint",))
            )
            continue
        ends = _ends_at_sites if model.eq_objtype[number] == SITE else _ends_in_bodies
        bodies, places, attitude = ends(model, number, kind)
        loops.append(Loop(model.equality(number).name, kind, bodies, places, attitude))
    return tuple(loops), tuple(others)


def _ends_in_bodies(model: Any, number: int, kind: LoopKind) -> Ends:
    """The ends of an equality constraint between two bodies."""
    first, second = np.array(model.eq_data[number, :3]), np.array(model.eq_data[number, 3:6])
    # A weld's anchor belongs to its second body, a connect's first point to its first.
    places = (first, second) if kind == "connect" else (second, first)
    bodies = (int(model.eq_obj1id[number]), int(model.eq_obj2id[number]))
    return bodies, places, np.array(model.eq_data[number, 6:10])


def _ends_at_sites(model: Any, number: int, kind: LoopKind) -> Ends:
    """The ends of an equality constraint between two sites: the sites' bodies, the sites' places,
    and the attitude of the second body in the first at which the sites' frames coincide."""
    sites = [int(model.eq_obj1id[number]), int(model.eq_obj2id[number])]
    bodies = (int(model.site_bodyid[sites[0]]), int(model.site_bodyid[sites[1]]))
    inverse, attitude = np.zeros(4), np.zeros(4)
    mujoco.mju_negQuat(inverse, model.site_quat[sites[1]])
    mujoco.mju_mulQuat(attitude, model.site_quat[sites[0]], inverse)
    places = (np.array(model.site_pos[sites[0]]), np.array(model.site_pos[sites[1]]))
    return bodies, places, attitude


def _shape(model: Any, geom: int) -> Shape:
    """The record of a geom of a model."""
    kind = SHAPE_KINDS[int(model.geom_type[geom])]
    points = np.zeros((0, 3))
    if kind == "hull":
        mesh = int(model.geom_dataid[geom])
        first = model.mesh_vertadr[mesh]
        points = np.array(model.mesh_vert[first : first + model.mesh_vertnum[mesh]], float)
    return Shape(
        name=model.geom(geom).name,
        kind=kind,
        body=int(model.geom_bodyid[geom]),
        place=np.array(model.geom_pos[geom]),
        attitude=np.array(model.geom_quat[geom]),
        size=np.array(model.geom_size[geom, : SIZES.get(kind, 3)]),
        points=points,
    )


def _touching(
    model: Any, pairs: Sequence[Sequence[int]], numbers: Mapping[int, int]
) -> Iterator[Touch]:
    """Yields a record for each of the `pairs` of geoms that can touch, with the friction that
    MuJoCo gives the pair. `numbers` is {number of a geom: number of its shape in the mechanism}."""
    listed = {
        tuple(sorted(pair)): number
        for number, pair in enumerate(
            zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True)
        )
    }
    for first, second in pairs:
        number = listed.get((first, second))
        if number is None:
            dimensions, friction = _mixed(model, first, second)
        else:
            dimensions = int(model.pair_dim[number])
            friction = model.pair_friction[number].tolist()
        # A contact of dimension 1 has no friction; 3 adds sliding, 4 torsional, 6 rolling friction.
        acting = (dimensions >= 3, dimensions >= 3, dimensions >= 4, *[dimensions >= 6] * 2)
        sliding_1, sliding_2, torsional, rolling_1, rolling_2 = (
            value * acts for value, acts in zip(friction, acting, strict=True)
        )
        yield Touch(
            shapes=(numbers[first], numbers[second]),
            sliding=(sliding_1, sliding_2),
            torsional=torsional,
            rolling=(rolling_1, rolling_2),
        )


def _mixed(model: Any, first: int, second: int) -> tuple[int, list[float]]:
    """The dimension and the five friction coefficients of a contact between two geoms: those of the
    geom with the higher priority; at equal priority the larger value of each."""
    geoms = [first, second]
    highest = model.geom_priority[geoms].max()
    deciding = [g for g in geoms if model.geom_priority[g] == highest]
    sliding, torsional, rolling = model.geom_friction[deciding].max(axis=0).tolist()
    dimensions = int(model.geom_condim[deciding].max())
    return dimensions, [sliding, sliding, torsional, rolling, rolling]


def _actuators(model: Any) -> tuple[tuple[Actuator, ...], tuple[NotExpressed, ...]]:
    """The records of actuators on hinges and slides, and the names of all other actuators."""
    actuators = list[Actuator]()
    others = list[NotExpressed]()
    if model.opt.disableflags & BITS.mjDSBL_ACTUATION:
        return (), ()
    clamped = not model.opt.disableflags & BITS.mjDSBL_CLAMPCTRL
    for number in range(model.nactuator):
        if not _simple(model, number):
            others.append(
                NotExpressed(name_with_kind(model, "actuator", number), ("actuator",))
            )
            continue
        control = int(model.actuator_ctrladr[number])
        bias = model.actuator_biasprm[number, :3] * (model.actuator_biastype[number] == AFFINE)
        limited = clamped and model.actuator_ctrllimited[control]
        actuators.append(
            Actuator(
                name=model.actuator(number).name,
                joint=int(model.actuator_trnid[number, 0]),
                control=control,
                gear=float(model.actuator_gear[number, 0]),
                gain=float(model.actuator_gainprm[number, 0]),
                bias=(float(bias[0]), float(bias[1]), float(bias[2])),
                control_range=_range(limited, model.actuator_ctrlrange[control]),
                force_range=_range(
                    model.actuator_forcelimited[number], model.actuator_forcerange[number]
                ),
            )
        )
    return tuple(actuators), tuple(others)


def _simple(model: Any, number: int) -> bool:
    """Whether an actuator acts on a hinge or a slide with a force that is linear in its control,
    the joint's coordinate and the joint's velocity."""
    on_joint = int(model.actuator_trntype[number]) in (
        int(mujoco.mjtTrn.mjTRN_JOINT),
        int(mujoco.mjtTrn.mjTRN_JOINTINPARENT),
    )
    one = on_joint and int(model.jnt_type[model.actuator_trnid[number, 0]]) in ONE_DEGREE
    linear = (
        int(model.actuator_dyntype[number]) == int(mujoco.mjtDyn.mjDYN_NONE)
        and model.actuator_gaintype[number] == FIXED
        and model.actuator_biastype[number] in (int(mujoco.mjtBias.mjBIAS_NONE), AFFINE)
    )
    plain = model.actuator_ctrlnum[number] == 1 and model.actuator_plugin[number] < 0
    return bool(one and linear and plain)


def _not_expressed(model: Any) -> Iterator[NotExpressed]:
    """Names the parts of a model, other than equalities and actuators, for which a mechanism has no
    record."""

    def parts(what: str, kind: str, numbers: Any, *terms: Term) -> Iterator[NotExpressed]:
        for number in numbers.tolist():
            yield NotExpressed(what + name_with_kind(model, kind, number), terms)

    for number in range(model.ntendon):
        name = name_with_kind(model, "tendon", number)
        yield NotExpressed(name, _terms_of_tendon(model, number))
    yield from parts("", "flex", np.arange(model.nflex), "passive", "constraint")
    plug_ins = np.flatnonzero(model.body_plugin >= 0)
    yield from parts("plug-in of ", "body", plug_ins, "passive")
    if model.opt.density or model.opt.viscosity:
        yield NotExpressed("drag of the medium", ("passive",))
    nonlinear = np.flatnonzero(np.any(model.jnt_stiffnesspoly, axis=1))
    yield from parts("nonlinear spring of ", "joint", nonlinear, "passive")
    nonlinear = model.dof_jntid[np.any(model.dof_dampingpoly, axis=1)]
    yield from parts("nonlinear damping of ", "joint", nonlinear, "passive")
    held = np.flatnonzero(model.jnt_actgravcomp)
    what = "gravity compensation by actuators of "
    yield from parts(what, "joint", held, "passive", "actuator")
    yield from parts("motion capture of ", "body", np.flatnonzero(model.body_mocapid >= 0))
    colliding = (model.geom_contype | model.geom_conaffinity) != 0
    unknown = ~np.isin(model.geom_type, list(SHAPE_KINDS))
    yield from parts("", "geom", np.flatnonzero(colliding & unknown), "constraint")


def _terms_of_tendon(model: Any, number: int) -> tuple[Term, ...]:
    """The terms of the equations of motion to which a tendon contributes. Forces of actuators on
    the tendon do not count: they belong to the actuators."""
    terms = list[Term]()
    if model.tendon_armature[number]:
        terms += ["mass matrix", "bias"]
    if model.tendon_stiffness[number] or model.tendon_damping[number]:
        terms.append("passive")
    if model.tendon_limited[number] or model.tendon_frictionloss[number]:
        terms.append("constraint")
    return tuple(terms)
