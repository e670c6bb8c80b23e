"""A user's model file in DART: the numbers that DART reads from it, and runs of its model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.abilities import Fields
from plumbob.engines.peer_model import (
    FREE_VELOCITIES,
    EngineJoint,
    FreeJointFrame,
    Layout,
    MechanismDiffers,
    PeerModel,
    RefusedFile,
    Translated,
)
from plumbob.models.border import border

WORLD_GEOM = "__geom_skel__"  # prefix of the names of skeletons that are geoms of the world


def _read(path: Path) -> Any:
    """The world that DART makes of a file; raises RefusedFile, and NotRead if DART makes none."""
    import dartpy

    with border(RefusedFile):
        world = dartpy.utils.MjcfParser.readWorld(str(path.resolve()))
    if world is None:
        raise MechanismDiffers("DART makes no world of it")
    return world


def model_fields(path: Path) -> Fields:
    """The numbers that DART reads from a model file; raises RefusedFile."""
    world = _read(path)
    yield "gravity", "", world.getGravity()
    yield "timestep", "", world.getTimeStep()
    for skeleton in map(world.getSkeleton, range(world.getNumSkeletons())):
        for body in map(skeleton.getBodyNode, range(skeleton.getNumBodyNodes())):
            if not skeleton.getName().startswith(WORLD_GEOM):
                moments = np.linalg.eigvalsh(body.getInertia().getMoment())
                yield "mass", body.getName(), body.getMass()
                yield "inertia", body.getName(), moments
            for shape in map(body.getShapeNode, range(body.getNumShapeNodes())):
                if shape.hasDynamicsAspect():
                    geom_name = skeleton.getName().removeprefix(WORLD_GEOM)
                    unnamed = "ShapeNode" in shape.getName()
                    name = geom_name if unnamed else shape.getName()
                    yield "friction", name, shape.getDynamicsAspect().getFrictionCoeff()
        for dof in map(skeleton.getDof, range(skeleton.getNumDofs())):
            yield "damping", dof.getName(), dof.getDampingCoefficient()
            yield "stiffness", dof.getName(), dof.getSpringStiffness()
            yield "frictionloss", dof.getName(), dof.getCoulombFriction()


class DartModel:
    """The world of a file. Its coordinates are those of the skeletons, one skeleton after
    another."""

    def __init__(self, path: Path, step: float) -> None:
        self.world = _read(path)
        self.world.setTimeStep(step)
        skeletons = map(self.world.getSkeleton, range(self.world.getNumSkeletons()))
        self.skeletons = [skeleton for skeleton in skeletons if skeleton.getNumDofs()]
        counts = [skeleton.getNumDofs() for skeleton in self.skeletons]
        self.places = np.cumsum([0, *counts])[:-1].tolist()

    def put(self, q: Array, v: Array) -> None:
        """Sets the coordinates and their rates."""
        parts = zip(self.skeletons, self._split(q), self._split(v), strict=True)
        for skeleton, positions, rates in parts:
            skeleton.setPositions(positions)
            skeleton.setVelocities(rates)

    def _split(self, values: Array) -> list[Array]:
        """One array for each skeleton, from the values of all coordinates."""
        return np.split(values, self.places[1:])

    def terms(self, q: Array, v: Array, control: Array) -> dict[str, Any]:
        """The terms of the equations of motion, and the pairs of bodies that touch. DART reads no
        actuators from a file."""
        import dartpy
        from scipy.linalg import block_diag

        self.put(q, v)
        skeletons = self.skeletons
        dofs = list[Any]()
        for skeleton in skeletons:
            dofs += map(skeleton.getDof, range(skeleton.getNumDofs()))
        damping = np.array([dof.getDampingCoefficient() for dof in dofs])
        springs = [
            dof.getSpringStiffness() * (position - dof.getRestPosition())
            for dof, position in zip(dofs, q, strict=True)
        ]
        touching = dartpy.collision.CollisionResult()
        self.world.checkCollision(dartpy.collision.CollisionOption(), touching)
        masses = [skeleton.getMassMatrix() for skeleton in skeletons]
        return {
            "mass matrix": block_diag(*masses),
            "gravity": -np.concatenate([each.getGravityForces() for each in skeletons]),
            "bias": np.concatenate([each.getCoriolisForces() for each in skeletons]),
            "passive": -damping * v - np.array(springs),
            "actuator": np.zeros(len(v)),
            "damping": damping,
            "contacts": [_names_of_bodies(contact) for contact in touching.getContacts()],
        }

    def advance(self, control: Array, force: Array, steps: int) -> tuple[Array, Array]:
        """Takes `steps` steps under a generalised `force`, which is held; returns the coordinates
        and their rates. DART reads no actuators: the control has no effect."""
        for _ in range(steps):
            for skeleton, part in zip(self.skeletons, self._split(force), strict=True):
                skeleton.setForces(part)
            self.world.step()
        q, v = (
            np.concatenate([getattr(skeleton, name)() for skeleton in self.skeletons])
            for name in ("getPositions", "getVelocities")
        )
        return q, v


def _names_of_bodies(contact: Any) -> tuple[str, ...]:
    """The names of the two bodies of a contact."""
    shapes = (contact.collisionObject1, contact.collisionObject2)
    nodes = (shape.getShapeFrame().asShapeNode() for shape in shapes)
    return tuple(node.getBodyNodePtr().getName() for node in nodes)


def _frame(joint: Any) -> FreeJointFrame:
    """The conversion between a body's pose and the coordinates of its free joint, which count from
    the pose that the file gives the body."""
    from scipy.spatial.transform import Rotation

    drawn_pose = joint.getTransformFromParentBodyNode()
    origin = drawn_pose.translation().ravel()
    drawn_turn = Rotation.from_matrix(drawn_pose.rotation())

    def coordinates(place: Array, attitude: Array) -> Array:
        """DART's coordinates of a pose."""
        back = drawn_turn.inv()
        turn = back * Rotation.from_quat(attitude, scalar_first=True)
        return np.concatenate([turn.as_rotvec(), back.apply(place - origin)])

    def pose(q: Array) -> tuple[Array, Array]:
        """The place [m] and the attitude of DART's coordinates."""
        turn = drawn_turn * Rotation.from_rotvec(q[:3])
        return origin + drawn_turn.apply(q[3:]), turn.as_quat(scalar_first=True)

    return FreeJointFrame(coordinates, pose, FREE_VELOCITIES)


def user_model(path: Path, layout: Layout, step: float) -> PeerModel:
    """The model of a file in DART at `step` [s], with the places of its joints in DART's
    coordinates; raises NotRead."""
    model = DartModel(path, step)
    joints = []
    for skeleton, first in zip(model.skeletons, model.places, strict=True):
        for joint in map(skeleton.getJoint, range(skeleton.getNumJoints())):
            if joint.getNumDofs():
                place = first + joint.getIndexInSkeleton(0)
            if joint.getNumDofs() == 1:
                joints.append(EngineJoint(place, place, joint.getName()))
            elif joint.getNumDofs() == FREE_VELOCITIES:
                joints.append(EngineJoint(place, place, frame=_frame(joint)))
    return Translated(model, layout, joints, displaced=True)
