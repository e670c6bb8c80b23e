"""Makes the mechanism of a compiled MuJoCo model, and names parts that a mechanism cannot
express."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import chain
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.colliding_pairs import colliding_pairs
from plumbob.engines.adapters.mujoco.model_fields import (
    ONE_DEGREE,
    actuator_count,
    control_counts,
    name_with_kind,
)
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
# Count of size numbers of a geom, by kind; kinds that are not listed have three.
SIZES = MappingProxyType({"sphere": 1, "capsule": 2, "cylinder": 2, "plane": 0, "hull": 0})
FIXED, AFFINE = int(mujoco.mjtGain.mjGAIN_FIXED), int(mujoco.mjtBias.mjBIAS_AFFINE)
# Least dimension of a contact at which two sliding, a torsional and two rolling coefficients act
LEAST_DIMENSIONS = (3, 3, 4, 6, 6)
ON_JOINT = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
SITE = int(mujoco.mjtObj.mjOBJ_SITE)


def compiled_mechanism(model: Any) -> Mechanism:
    """The mechanism of a compiled model. If the model disables gravity, springs or dampers, their
    numbers are zero in the mechanism."""
    pairs = colliding_pairs(model)[0].tolist()
    geoms = sorted(set(chain(*pairs)))
    disabled = model.opt.disableflags
    return Mechanism(
        bodies=tuple(_body(model, number) for number in range(model.nbody)),
        joints=tuple(_joint(model, number) for number in range(model.njnt)),
        loops=tuple(_loops(model)),
        shapes=tuple(_shape(model, geom) for geom in geoms),
        touching=tuple(_touching(model, pairs, geoms)),
        actuators=tuple(_actuators(model)),
        gravity=np.zeros(3) if disabled & BITS.mjDSBL_GRAVITY else np.array(model.opt.gravity),
        not_expressed=tuple(map(NotExpressed, _not_expressed(model))),
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
    disabled = model.opt.disableflags
    stiffness = 0.0 if disabled & BITS.mjDSBL_SPRING else float(model.jnt_stiffness[number])
    damped = not disabled & BITS.mjDSBL_DAMPER
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


def _loops(model: Any) -> Iterator[Loop]:
    """The records of a model's active equality constraints that connect or weld two bodies."""
    for number in np.flatnonzero(model.eq_active0).tolist():
        kind = LOOP_KINDS.get(int(model.eq_type[number]))
        if kind is not None:
            at_sites = model.eq_objtype[number] == SITE
            loop = _loop_of_sites if at_sites else _loop_of_bodies
            yield loop(model, number, kind)


def _loop_of_bodies(model: Any, number: int, kind: LoopKind) -> Loop:
    """The record of an equality constraint between two bodies."""
    point, other_point = (
        np.array(model.eq_data[number, :3]),
        np.array(model.eq_data[number, 3:6]),
    )
    # The first point in eq_data is on the first body of a connect, but on the second of a weld.
    places = (point, other_point) if kind == "connect" else (other_point, point)
    bodies = (int(model.eq_obj1id[number]), int(model.eq_obj2id[number]))
    attitude = np.array(model.eq_data[number, 6:10])
    return Loop(model.equality(number).name, kind, bodies, places, attitude)


def _loop_of_sites(model: Any, number: int, kind: LoopKind) -> Loop:
    """The record of an equality constraint between two sites, as a constraint between their bodies:
    the sites' places, and the attitude of the second body in the first at which the sites' frames
    coincide."""
    first, second = int(model.eq_obj1id[number]), int(model.eq_obj2id[number])
    bodies = (int(model.site_bodyid[first]), int(model.site_bodyid[second]))
    places = (np.array(model.site_pos[first]), np.array(model.site_pos[second]))
    inverse, attitude = np.zeros(4), np.zeros(4)
    mujoco.mju_negQuat(inverse, model.site_quat[second])
    mujoco.mju_mulQuat(attitude, model.site_quat[first], inverse)
    return Loop(model.equality(number).name, kind, bodies, places, attitude)


def _shape(model: Any, geom: int) -> Shape:
    """The record of a geom of a model."""
    kind = SHAPE_KINDS[int(model.geom_type[geom])]
    return Shape(
        name=model.geom(geom).name,
        kind=kind,
        body=int(model.geom_bodyid[geom]),
        place=np.array(model.geom_pos[geom]),
        attitude=np.array(model.geom_quat[geom]),
        size=np.array(model.geom_size[geom, : SIZES.get(kind, 3)]),
    )


def _touching(
    model: Any, pairs: Sequence[Sequence[int]], geoms: Sequence[int]
) -> Iterator[Touch]:
    """Yields a record for each of the `pairs` of geoms that can touch, with the friction that
    MuJoCo gives the pair. `geoms` has the geom of each shape of the mechanism."""
    shape_of_geom = {geom: shape for shape, geom in enumerate(geoms)}
    declared_pairs = zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True)
    declared = {tuple(sorted(pair)): number for number, pair in enumerate(declared_pairs)}
    for pair in pairs:
        number = declared.get(tuple(pair))
        if number is None:
            dimensions, coefficients = _mixed(model, pair)
        else:
            dimensions = int(model.pair_dim[number])
            coefficients = model.pair_friction[number].tolist()
        acting = [
            coefficient * (dimensions >= least)
            for coefficient, least in zip(coefficients, LEAST_DIMENSIONS, strict=True)
        ]
        yield Touch(
            shapes=(shape_of_geom[pair[0]], shape_of_geom[pair[1]]),
            sliding=(acting[0], acting[1]),
            torsional=acting[2],
            rolling=(acting[3], acting[4]),
        )


def _mixed(model: Any, pair: Sequence[int]) -> tuple[int, list[float]]:
    """The dimension and the five friction coefficients of a contact between two geoms: those of the
    geom with the higher priority; at equal priority the larger value of each."""
    highest = model.geom_priority[pair].max()
    deciding = [geom for geom in pair if model.geom_priority[geom] == highest]
    sliding, torsional, rolling = model.geom_friction[deciding].max(axis=0).tolist()
    dimensions = int(model.geom_condim[deciding].max())
    return dimensions, [sliding, sliding, torsional, rolling, rolling]


def _actuators(model: Any) -> Iterator[Actuator]:
    """The records of the actuators that a mechanism can express."""
    if model.opt.disableflags & BITS.mjDSBL_ACTUATION:
        return
    clamped = not model.opt.disableflags & BITS.mjDSBL_CLAMPCTRL
    counts = control_counts(model)
    for number in filter(partial(_simple, model), range(actuator_count(model))):
        control = int(counts[:number].sum())
        bias = model.actuator_biasprm[number, :3] * (model.actuator_biastype[number] == AFFINE)
        limited = clamped and model.actuator_ctrllimited[control]
        yield Actuator(
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


def _simple(model: Any, number: int) -> bool:
    """Whether an actuator acts on a hinge or a slide with a force that is linear in its control,
    the joint's coordinate and the joint's velocity."""
    on_joint = int(model.actuator_trntype[number]) in ON_JOINT
    one_degree = on_joint and int(model.jnt_type[model.actuator_trnid[number, 0]]) in ONE_DEGREE
    linear = (
        int(model.actuator_dyntype[number]) == int(mujoco.mjtDyn.mjDYN_NONE)
        and model.actuator_gaintype[number] == FIXED
        and model.actuator_biastype[number] in (int(mujoco.mjtBias.mjBIAS_NONE), AFFINE)
    )
    one_control = control_counts(model)[number] == 1
    no_plug_in = model.actuator_plugin[number] < 0
    return bool(one_degree and linear and one_control and no_plug_in)


def _not_expressed(model: Any) -> Iterator[str]:
    """Names the parts of a model for which a mechanism has no record."""

    def names(kind: str, numbers: Any, what: str = "") -> list[str]:
        """The names of the parts of a kind with these numbers, after the word for `what` they
        have."""
        return [what + name_with_kind(model, kind, int(number)) for number in numbers]

    active = np.flatnonzero(model.eq_active0)
    other_kinds = ~np.isin(model.eq_type[active], list(LOOP_KINDS))
    yield from names("equality", active[other_kinds])
    if not model.opt.disableflags & BITS.mjDSBL_ACTUATION:
        actuators = range(actuator_count(model))
        others = [actuator for actuator in actuators if not _simple(model, actuator)]
        yield from names("actuator", others)
    yield from names("tendon", range(model.ntendon))
    yield from names("flex", range(model.nflex))
    yield from names("body", np.flatnonzero(model.body_plugin >= 0), "plug-in of ")
    if model.opt.density or model.opt.viscosity:
        yield "drag of the medium"
    nonlinear_springs = np.flatnonzero(np.any(model.jnt_stiffnesspoly, axis=1))
    yield from names("joint", nonlinear_springs, "nonlinear spring of ")
    nonlinear_dampers = model.dof_jntid[np.any(model.dof_dampingpoly, axis=1)]
    yield from names("joint", nonlinear_dampers, "nonlinear damping of ")
    compensated = np.flatnonzero(model.jnt_actgravcomp)
    yield from names("joint", compensated, "gravity compensation by actuators of ")
    yield from names("body", np.flatnonzero(model.body_mocapid >= 0), "motion capture of ")
    colliding = (model.geom_contype | model.geom_conaffinity) != 0
    other_shapes = ~np.isin(model.geom_type, list(SHAPE_KINDS))
    yield from names("geom", np.flatnonzero(colliding & other_shapes))
