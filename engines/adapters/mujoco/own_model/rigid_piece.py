"""A free body of a user's model as one rigid piece on a plane, with its joints locked and
everything else removed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.model_fields import name_of
from plumbob.engines.adapters.mujoco.solids import mesh_vertices
from plumbob.engines.own_motion import NotCertifiable

# Largest sine of the angle between gravity and the plane's normal that counts as zero, and largest
# ratio of a force to the body's mass [m/s^2] that counts as no force
LEVEL = 1e-9
PAIR = ("margin", "gap", "friction", "solref", "solreffriction", "solimp")
CONTACT = (
    *("condim", "priority", "solmix", "margin", "gap", "contype", "conaffinity"),
    *("friction", "solref", "solimp"),
)
FLOOR, BODY = "floor", "base"


@dataclass(frozen=True)
class RigidPiece:
    """The piece as a compiled model whose plane is z = 0, and its origin in the user's model."""

    model: Any  # mjModel: a plane and a free body, whose frame is at its centre of mass
    spec: Any  # MjSpec of it
    geoms: tuple[str, ...]  # names in the user's model, by the numbers of the piece's geoms
    body: str
    plane: str
    plane_number: int  # number of the plane's geom in the user's model
    locked: int  # number of locked joints
    inertia: float  # about the vertical [kg m^2]
    notes: tuple[str, ...]  # names of forces on the body at the start that the piece lacks


def rigid_piece(
    model: Any, data: Any, body: str | None, friction: float | None = None
) -> RigidPiece:
    """Returns the free body `body` of `model`, or the heaviest that a plane can touch, in the
    posture of `data`, whose positions are computed, with sliding `friction` in place of its own.
    Raises ParameterError, and NotCertifiable if the body cannot slide on a plane."""
    if model.opt.enableflags & mujoco.mjtEnableBit.mjENBL_OVERRIDE:
        raise NotCertifiable("the model overrides the settings of every contact")
    root = _free_body(model, body)
    inside = np.flatnonzero(model.body_rootid == root)
    plane, geoms = _plane_and_geoms(model, data, root)
    turn = np.array(data.geom_xmat[plane]).reshape(3, 3)
    gravity = _normal_gravity(model, plane, turn)
    centre = data.subtree_com[root]
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(name=FLOOR, type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    _copy_contact_settings(spec.geoms[0], model, plane)
    inertia = turn.T @ _inertia(data, root) @ turn
    piece = spec.worldbody.add_body(name=BODY, mass=float(model.body_subtreemass[root]))
    piece.add_freejoint()
    piece.explicitinertial = True
    piece.inertia, axes = np.linalg.eigh(inertia)
    axes[:, 2] *= np.linalg.det(axes)  # right-handed
    piece.iquat = _quaternion(axes)
    copy = GeomCopy(spec, piece, model, data, turn, centre)
    for number, geom in enumerate(geoms):
        copy.add(geom, f"geom_{number}")
    _copy_pairs(spec, model, plane, geoms)
    compiled = _compiled(spec, model, gravity)
    if friction is not None:
        compiled.geom_friction[:, 0] = compiled.pair_friction[:, :2] = friction
    _lower_to_plane(compiled)
    return RigidPiece(
        model=compiled,
        spec=spec,
        geoms=tuple(name_of(model, "geom", geom) for geom in geoms),
        body=name_of(model, "body", root),
        plane=name_of(model, "geom", plane),
        plane_number=plane,
        locked=int(model.body_jntnum[inside].sum()) - 1,
        inertia=float(inertia[2, 2]),
        notes=tuple(_forces_left_out(model, data, root, plane)),
    )


def _normal_gravity(model: Any, plane: int, turn: Array) -> float:
    """Returns gravity along the normal of the plane [m/s^2]. Raises NotCertifiable if gravity is
    not along the normal."""
    gravity = turn.T @ model.opt.gravity
    if not gravity[2] < 0.0 or np.hypot(*gravity[:2]) > -LEVEL * gravity[2]:
        what = "no gravity" if not gravity.any() else "gravity that is not normal to its plane"
        raise NotCertifiable(f"the model has {what} ({name_of(model, 'geom', plane)})")
    return float(gravity[2])


def _compiled(spec: Any, model: Any, gravity: float) -> Any:
    """Returns the compiled piece with the options of `model` except for drag. Raises
    NotCertifiable."""
    try:
        compiled = spec.compile()
    except ValueError as error:
        raise NotCertifiable(f"its geoms cannot be copied ({error})") from None
    compiled.opt = model.opt
    compiled.opt.gravity[:] = 0.0, 0.0, gravity
    compiled.opt.density = compiled.opt.viscosity = 0.0
    return compiled


def _forces_left_out(model: Any, data: Any, root: int, plane: int) -> Iterator[str]:
    """Yields the names of the forces that act on the free joint of the body at the start and are
    not copied."""
    if model.opt.density or model.opt.viscosity:
        yield "the medium"
    first = model.body_dofadr[root]
    floor = (data.contact.geom == plane).any(axis=1)
    contact_kinds = int(mujoco.mjtConstraint.mjCNSTR_CONTACT_FRICTIONLESS)
    on_floor = [
        kind >= contact_kinds and floor[contact]
        for kind, contact in zip(data.efc_type, data.efc_id, strict=True)
    ]
    constrained = np.zeros(model.nv)
    mujoco.mj_mulJacTVec(model, data, constrained, np.where(on_floor, 0.0, 1.0))
    acting = {
        "passive forces": data.qfrc_passive,
        "forces of actuators": data.qfrc_actuator,
        "other constraints and contacts": constrained,
    }
    for name, forces in acting.items():
        if abs(forces[first : first + 6]).max() > LEVEL * model.body_subtreemass[root]:
            yield name


def _free_body(model: Any, name: str | None) -> int:
    """Returns the number of the named free body, or of the heaviest. Raises ParameterError, and
    NotCertifiable if there is no free body."""
    free: list[int] = model.jnt_bodyid[model.jnt_type == mujoco.mjtJoint.mjJNT_FREE].tolist()
    if not free:
        raise NotCertifiable("the model has no free body: nothing in it slides on a plane")
    if name is None:
        return max(free, key=lambda body: model.body_subtreemass[body])
    numbers = {name_of(model, "body", body): body for body in free}
    if name not in numbers:
        raise ParameterError("body", name, f"a free body: {', '.join(numbers)}")
    return numbers[name]


def _plane_and_geoms(model: Any, data: Any, root: int) -> tuple[int, list[int]]:
    """Returns the plane under the body, and the geoms of the body that it can touch. Raises
    NotCertifiable."""
    bodies = model.geom_bodyid
    flat = model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE
    planes = np.flatnonzero(flat & (model.body_weldid[bodies] == 0)).tolist()
    geoms_of_body = np.flatnonzero(model.body_rootid[bodies] == root).tolist()
    touching = {
        plane: [geom for geom in geoms_of_body if _can_touch(model, plane, geom)]
        for plane in planes
    }
    reachable = {plane: geoms for plane, geoms in touching.items() if geoms}
    if not reachable:
        raise NotCertifiable("the model has no plane that its free body can touch")

    def lowest(plane: int) -> float:
        """The smallest height of a geom's centre above a plane [m]."""
        arms = data.geom_xpos[reachable[plane]] - data.geom_xpos[plane]
        return float((arms @ data.geom_xmat[plane, 2::3]).min())

    plane = min(reachable, key=lowest)
    for geom in reachable[plane]:
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_SDF:
            raise NotCertifiable(
                f"the shape of {name_of(model, 'geom', geom)} cannot be copied"
            )
    return plane, reachable[plane]


def _can_touch(model: Any, plane: int, geom: int) -> bool:
    """Whether a plane and a geom can touch."""
    if frozenset((plane, geom)) in _pairs_of(model):
        return True
    bodies = sorted((int(model.geom_bodyid[plane]), int(model.geom_bodyid[geom])))
    if (bodies[0] << 16) + bodies[1] in model.exclude_signature.tolist():
        return False
    return bool(
        (model.geom_contype[plane] & model.geom_conaffinity[geom])
        | (model.geom_contype[geom] & model.geom_conaffinity[plane])
    )


def _pairs_of(model: Any) -> dict[frozenset[int], int]:
    """Returns {two geoms: number of their contact pair} of the model."""
    pairs = zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True)
    return {frozenset(pair): number for number, pair in enumerate(pairs)}


def _inertia(data: Any, body: int) -> Array:
    """Returns the inertia of a body and all bodies that hang on it, about their centre of mass, in
    the world's axes [kg m^2], shape (3, 3)."""
    xx, yy, zz, xy, xz, yz = data.crb[body][:6]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@dataclass(frozen=True)
class GeomCopy:
    """Copies geoms of the user's model to the piece."""

    spec: Any  # MjSpec of the piece
    piece: Any  # its body
    model: Any  # mjModel of the user
    data: Any  # mjData of the user, whose positions are computed
    turn: Array  # axes of the plane in the world, shape (3, 3)
    centre: Array  # centre of mass of the piece in the world [m]

    def add(self, geom: int, name: str) -> None:
        """Adds a copy of a geom with a name, at its place relative to the centre of mass, in the
        axes of the plane."""
        model = self.model
        place = self.turn.T @ (self.data.geom_xpos[geom] - self.centre)
        axes = self.turn.T @ np.array(self.data.geom_xmat[geom]).reshape(3, 3)
        kind = mujoco.mjtGeom(int(model.geom_type[geom]))
        added = self.piece.add_geom(name=name, type=kind, pos=place, quat=_quaternion(axes))
        if kind == mujoco.mjtGeom.mjGEOM_MESH:
            added.meshname = self._mesh_name(geom)
        else:
            added.size = model.geom_size[geom]
        _copy_contact_settings(added, model, geom)

    def _mesh_name(self, geom: int) -> str:
        """Returns the name of the piece's copy of a geom's mesh. If the piece has no copy of the
        mesh yet, the mesh is copied to it first."""
        model = self.model
        mesh = int(model.geom_dataid[geom])
        name = f"mesh_{mesh}"
        if all(other.name != name for other in self.spec.meshes):
            first = model.mesh_faceadr[mesh]
            faces = model.mesh_face[first : first + model.mesh_facenum[mesh]]
            copied = self.spec.add_mesh(name=name)
            copied.uservert = mesh_vertices(model, geom).ravel().tolist()
            copied.userface = faces.ravel().tolist()
            copied.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        return name


def _copy_contact_settings(target: Any, model: Any, geom: int) -> None:
    """Copies the contact settings of a geom."""
    for name in CONTACT:
        setattr(target, name, getattr(model, f"geom_{name}")[geom].tolist())


def _copy_pairs(spec: Any, model: Any, plane: int, geoms: list[int]) -> None:
    """Copies the contact pairs of the plane with the geoms."""
    pairs = _pairs_of(model)
    for number, geom in enumerate(geoms):
        pair = pairs.get(frozenset((plane, geom)))
        if pair is not None:
            added = spec.add_pair(geomname1=FLOOR, geomname2=f"geom_{number}")
            added.condim = int(model.pair_dim[pair])
            for name in PAIR:
                setattr(added, name, getattr(model, f"pair_{name}")[pair])


def _lower_to_plane(model: Any) -> None:
    """Lowers the piece until it touches, in its posture at the start; changed in place. Raises
    NotCertifiable if contacts are disabled."""
    if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT:
        raise NotCertifiable("no contact with the plane is made: contacts may be disabled")
    size = float(np.linalg.norm(model.geom_pos, axis=1).max() + model.geom_rbound.max())
    height = 4.0 * size  # at this height nothing touches the plane
    data = mujoco.MjData(model)
    data.qpos[2] = height
    mujoco.mj_kinematics(model, data)
    plane = 0
    gaps = [
        mujoco.mj_geomDistance(model, data, plane, geom, 2 * height, None)
        for geom in range(1, model.ngeom)
    ]
    model.qpos0[2] = height - min(gaps)


def _quaternion(axes: Array) -> Array:
    """Returns the quaternion, scalar first, of a rotation matrix."""
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(axes).ravel())
    return quaternion
