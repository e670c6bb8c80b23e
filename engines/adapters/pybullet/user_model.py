"""A user's model file in Bullet: the numbers that Bullet reads from it, and runs of its model.

The terms of the equations of motion are derived from the accelerations in very short steps without
contacts: from rest, under a unit force on one coordinate at a time, and with the velocities.
Bullet's inverse dynamics is not used, because its coordinates include fixed joints.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.abilities import Fields
from plumbob.engines.adapters.pybullet.client import BASE, new_client
from plumbob.engines.peer_model import (
    FREE_VELOCITIES,
    EngineJoint,
    FreeJointFrame,
    Layout,
    MechanismDiffers,
    PeerModel,
    RefusedFile,
    Translated,
    rotation,
)
from plumbob.models.border import border

PROBE = 1e-6  # [s] step that shows accelerations
DAMPED = "springs and damping dropped; velocities of links damped by Bullet's default"
WIDE = 1e10  # [rad] or [m] limit that no joint reaches


def model_fields(path: Path) -> Fields:
    """The numbers that Bullet reads from a model file. Bullet has one coefficient of friction for
    each body. Raises RefusedFile."""
    client = new_client()
    with border(RefusedFile):
        bodies = client.loadMJCF(str(path))
    options = client.getPhysicsEngineParameters()
    yield "gravity", "", [options[f"gravityAcceleration{axis}"] for axis in "XYZ"]
    yield "timestep", "", options["fixedTimeStep"]
    for body in bodies:
        for link in range(BASE, client.getNumJoints(body)):
            if link != BASE:
                _, joint_name, kind, _, _, _, damping, dry_friction, *_ = client.getJointInfo(
                    body, link
                )
                if kind != client.JOINT_FIXED:
                    yield "damping", joint_name.decode(), damping
                    yield "frictionloss", joint_name.decode(), dry_friction
            name = _link_name(client, body, link)
            mass, friction, moments, *_ = client.getDynamicsInfo(body, link)
            if mass > 0.0:  # the bodies that Bullet adds between joints have no mass
                yield "mass", name, mass
                yield "inertia", name, sorted(moments)
            yield "friction", name, friction


@dataclass(frozen=True)
class FloatingBase:
    """A floating body, whose coordinates are the place and the attitude of its centre of mass."""

    body: int
    places: slice  # its coordinates among those of the world
    rates: slice  # its rates among those of the world


@dataclass(frozen=True)
class ScalarJoint:
    """A hinge or a slide."""

    body: int
    link: int  # number of the link that it moves
    place: int  # number of its coordinate among those of the world
    rate: int  # number of its rate


class World:
    """A user's model in a separate simulation, without motors. The coordinates of a floating body
    are the place and the attitude of its centre of mass in the world; they come before the
    coordinates of the body's joints."""

    def __init__(self, path: Path, layout: Layout, step: float) -> None:
        client = self.client = new_client()
        with border(RefusedFile):
            self.bodies = client.loadMJCF(str(path))
        client.setPhysicsEngineParameter(fixedTimeStep=step, deterministicOverlappingPairs=1)
        self.bases = list[FloatingBase]()
        self.joints = list[ScalarJoint]()
        self.positions = 0  # number of coordinates
        self.velocities = 0  # number of rates
        floating = sum(joint.size == FREE_VELOCITIES for joint in layout.joints)
        for body in self.bodies:
            mass, *_ = client.getDynamicsInfo(body, BASE)
            if mass > 0.0 and len(self.bases) < floating:
                self._add_base(body)
            for link in range(client.getNumJoints(body)):
                client.setJointMotorControl2(body, link, client.VELOCITY_CONTROL, force=0.0)
                self._add_joint(body, link)

    def _add_base(self, body: int) -> None:
        """Gives a floating body the next coordinates and rates."""
        places = slice(self.positions, self.positions + 7)
        rates = slice(self.velocities, self.velocities + FREE_VELOCITIES)
        self.bases.append(FloatingBase(body, places, rates))
        self.positions = places.stop
        self.velocities = rates.stop

    def _add_joint(self, body: int, link: int) -> None:
        """Gives the joint of a link the next coordinate and rate, unless the link is fixed."""
        client = self.client
        kind = client.getJointInfo(body, link)[2]
        if kind in (client.JOINT_REVOLUTE, client.JOINT_PRISMATIC):
            self.joints.append(ScalarJoint(body, link, self.positions, self.velocities))
            self.positions += 1
            self.velocities += 1
        elif kind != client.JOINT_FIXED:
            raise MechanismDiffers("it has a joint of a kind that is not compared")

    def without_contacts(self, **damping: float) -> World:
        """Removes the contacts and the limits of joints from this world, and sets its damping; a
        parameter of damping that is not given keeps Bullet's default. Returns the world."""
        client = self.client
        for body in self.bodies:
            for link in range(BASE, client.getNumJoints(body)):
                client.setCollisionFilterGroupMask(body, link, 0, 0)
                limits = {"jointLowerLimit": -WIDE, "jointUpperLimit": WIDE}
                if link == BASE:
                    limits = {}
                client.changeDynamics(body, link, **damping, **limits)
        return self

    def put(self, q: Array, v: Array) -> None:
        """Sets the coordinates `q` and their rates `v`."""
        client = self.client
        for base in self.bases:
            place, attitude = np.split(q[base.places], [3])
            client.resetBasePositionAndOrientation(base.body, place, np.roll(attitude, -1))
            client.resetBaseVelocity(base.body, *np.split(v[base.rates], 2))
        for joint in self.joints:
            client.resetJointState(joint.body, joint.link, q[joint.place], v[joint.rate])

    def advance(self, force: Array, steps: int = 1) -> tuple[Array, Array]:
        """Takes `steps` steps under a generalised `force`, which is held; returns the coordinates
        and their rates."""
        client = self.client
        for _ in range(steps):
            self._push(force)
            client.stepSimulation()
        q = np.zeros(self.positions)
        v = np.zeros(self.velocities)
        for base in self.bases:
            place, attitude = client.getBasePositionAndOrientation(base.body)
            q[base.places] = *place, *np.roll(attitude, 1)
            v[base.rates] = np.ravel(client.getBaseVelocity(base.body))
        for joint in self.joints:
            q[joint.place], v[joint.rate], *_ = client.getJointState(joint.body, joint.link)
        return q, v

    def _push(self, force: Array) -> None:
        """Applies a generalised force in the next step."""
        client = self.client
        for base in self.bases:
            linear, torque = np.split(force[base.rates], 2)
            centre, _ = client.getBasePositionAndOrientation(base.body)
            client.applyExternalForce(base.body, BASE, linear, centre, client.WORLD_FRAME)
            client.applyExternalTorque(base.body, BASE, torque, client.WORLD_FRAME)
        for joint in self.joints:
            client.setJointMotorControl2(
                joint.body, joint.link, client.TORQUE_CONTROL, force=force[joint.rate]
            )


class BulletModel:
    """A user's model in Bullet, with further worlds that show its contacts and its accelerations:
    one with contacts, one with Bullet's damping and no contacts, and one with neither."""

    def __init__(self, path: Path, layout: Layout, step: float) -> None:
        self.world = World(path, layout, step)
        self.touching = World(path, layout, PROBE)
        self.damped = World(path, layout, PROBE).without_contacts()
        self.undamped = World(path, layout, PROBE).without_contacts(
            linearDamping=0.0, angularDamping=0.0, jointDamping=0.0
        )
        self.put = self.world.put

    def _acceleration(self, world: World, q: Array, v: Array, force: Array) -> Array:
        """The acceleration of a world in a state under a generalised force."""
        world.put(q, v)
        _, rates = world.advance(force)
        return (rates - v) / PROBE

    def terms(self, q: Array, v: Array, control: Array) -> dict[str, Any]:
        """The terms of the equations of motion, as steps show them, and the pairs of bodies that
        touch. Bullet reads no actuators from a file."""
        zeros = np.zeros(len(v))
        undamped = self.undamped
        at_rest = self._acceleration(undamped, q, zeros, zeros)
        columns = [
            self._acceleration(undamped, q, zeros, unit_force) - at_rest
            for unit_force in np.eye(len(v))
        ]
        inertia = np.linalg.inv(np.array(columns).T)
        in_motion = self._acceleration(undamped, q, v, zeros)
        with_damping = self._acceleration(self.damped, q, v, zeros)
        return {
            "mass matrix": (inertia + inertia.T) / 2,
            "gravity": inertia @ at_rest,
            "bias": inertia @ (at_rest - in_motion),
            "passive": inertia @ (with_damping - in_motion),
            "actuator": zeros,
            "contacts": self._touching_bodies(q, v),
            "causes": {"passive": DAMPED},
        }

    def _touching_bodies(self, q: Array, v: Array) -> list[tuple[str, ...]]:
        """The names of the pairs of bodies that touch in a state."""
        client = self.touching.client
        self.touching.put(q, v)
        client.performCollisionDetection()
        names = list[tuple[str, ...]]()
        for point in client.getContactPoints() or ():
            _, body, other_body, link, other_link, _, _, _, distance, *_ = point
            if distance <= 0.0:
                name = _link_name(client, body, link)
                other_name = _link_name(client, other_body, other_link)
                names.append((name, other_name))
        return names

    def advance(self, control: Array, force: Array, steps: int) -> tuple[Array, Array]:
        """Takes `steps` steps under a generalised `force`, which is held; returns the coordinates
        and their rates. Bullet reads no actuators: the control has no effect."""
        return self.world.advance(force, steps)


def _link_name(client: Any, body: int, link: int) -> str:
    """The name of a link of a body."""
    base_name, *_ = client.getBodyInfo(body)
    encoded = base_name if link == BASE else client.getJointInfo(body, link)[12]
    name: str = encoded.decode()
    return name


def _frame(client: Any, body: int) -> FreeJointFrame:
    """The conversion between the pose of a floating body and Bullet's coordinates, which are the
    place of its centre of mass and its attitude."""
    arm = client.getDynamicsInfo(body, BASE)[3]
    return FreeJointFrame(
        lambda place, attitude: np.concatenate([place + rotation(attitude) @ arm, attitude]),
        lambda q: (q[:3] - rotation(q[3:]) @ arm, q[3:]),
        linear_first=True,
        arm=arm,
    )


def user_model(path: Path, layout: Layout, step: float) -> PeerModel:
    """The model of a file in Bullet at `step` [s], with the places of its joints in the coordinates
    of the world; raises NotRead."""
    model = BulletModel(path, layout, step)
    client = model.world.client
    joints = []
    for joint in model.world.joints:
        name = client.getJointInfo(joint.body, joint.link)[1].decode()
        joints.append(EngineJoint(joint.place, joint.rate, name))
    for base in model.world.bases:
        frame = _frame(client, base.body)
        joints.append(EngineJoint(base.places.start, base.rates.start, frame=frame))
    return Translated(model, layout, joints, displaced=True)
