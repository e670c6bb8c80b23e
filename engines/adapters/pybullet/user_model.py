"""A user's model file in Bullet: the numbers that Bullet reads from it, and runs of its model.

The terms of the equations of motion are derived from the accelerations in very short steps without
contacts: from rest, under a unit force on one coordinate at a time, and with the velocities.
Bullet's inverse dynamics is not used, because its coordinates include fixed joints.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.abilities import Fields
from plumbob.engines.adapters.pybullet.client import new_client
from plumbob.engines.peer_model import (
    FREE_VELOCITIES,
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
        for link in range(-1, client.getNumJoints(body)):
            if link < 0:
                name = client.getBodyInfo(body)[0].decode()
            else:
                joint = client.getJointInfo(body, link)
                if joint[2] != client.JOINT_FIXED:
                    yield "damping", joint[1].decode(), joint[6]
                    yield "frictionloss", joint[1].decode(), joint[7]
                name = joint[12].decode()
            mass, friction, moments, *_ = client.getDynamicsInfo(body, link)
            if mass > 0.0:  # the bodies that Bullet adds between joints have no mass
                yield "mass", name, mass
                yield "inertia", name, sorted(moments)
            yield "friction", name, friction


class World:
    """A user's model in a separate simulation, without motors. The coordinates of a floating body
    are the place and the attitude of its centre of mass in the world; they come before the
    coordinates of the body's joints."""

    def __init__(self, path: Path, layout: Layout, step: float) -> None:
        client = self.client = new_client()
        with border(RefusedFile):
            self.bodies = client.loadMJCF(str(path))
        client.setPhysicsEngineParameter(fixedTimeStep=step, deterministicOverlappingPairs=1)
        # for each floating body: its number, and the numbers of its first coordinate and rate
        self.bases: list[tuple[int, int, int]] = []
        # for each joint: its body, its number, and the numbers of its coordinate and rate
        self.joints: list[tuple[int, int, int, int]] = []
        floating = sum(joint.size == FREE_VELOCITIES for joint in layout.joints)
        q = v = 0  # number of coordinates and of rates so far
        for body in self.bodies:
            mass, *_ = client.getDynamicsInfo(body, -1)
            if mass > 0.0 and len(self.bases) < floating:
                self.bases.append((body, q, v))
                q += 7
                v += FREE_VELOCITIES
            for joint in range(client.getNumJoints(body)):
                kind = client.getJointInfo(body, joint)[2]
                client.setJointMotorControl2(body, joint, client.VELOCITY_CONTROL, force=0.0)
                if kind in (client.JOINT_REVOLUTE, client.JOINT_PRISMATIC):
                    self.joints.append((body, joint, q, v))
                    q += 1
                    v += 1
                elif kind != client.JOINT_FIXED:
                    raise MechanismDiffers("it has a joint of a kind that is not compared")
        self.size = q, v

    def without_contacts(self, **damping: float) -> World:
        """Removes the contacts and the limits of joints from this world, and sets its damping; a
        parameter of damping that is not given keeps Bullet's default. Returns the world."""
        client = self.client
        for body in self.bodies:
            for link in range(-1, client.getNumJoints(body)):
                client.setCollisionFilterGroupMask(body, link, 0, 0)
                limits = {"jointLowerLimit": -WIDE, "jointUpperLimit": WIDE}
                if link < 0:
                    limits = {}
                client.changeDynamics(body, link, **damping, **limits)
        return self

    def put(self, q: Array, v: Array) -> None:
        """Sets the coordinates and their rates."""
        for body, at, rate in self.bases:
            attitude = np.roll(q[at + 3 : at + 7], -1)
            self.client.resetBasePositionAndOrientation(body, q[at : at + 3], attitude)
            self.client.resetBaseVelocity(
                body, v[rate : rate + 3], v[rate + 3 : rate + FREE_VELOCITIES]
            )
        for body, joint, at, rate in self.joints:
            self.client.resetJointState(body, joint, q[at], v[rate])

    def advance(self, force: Array, steps: int = 1) -> tuple[Array, Array]:
        """Takes `steps` steps under a generalised `force`, which is held; returns the coordinates
        and their rates."""
        client = self.client
        (q, v) = map(np.zeros, self.size)
        for _ in range(steps):
            self._push(force)
            client.stepSimulation()
        for body, at, rate in self.bases:
            place, attitude = client.getBasePositionAndOrientation(body)
            q[at : at + 7] = *place, *np.roll(attitude, 1)
            v[rate : rate + FREE_VELOCITIES] = np.ravel(client.getBaseVelocity(body))
        for body, joint, at, rate in self.joints:
            q[at], v[rate] = client.getJointState(body, joint)[:2]
        return q, v

    def _push(self, force: Array) -> None:
        """Applies a generalised force in the next step."""
        client = self.client
        for body, _, rate in self.bases:
            linear = force[rate : rate + 3]
            torque = force[rate + 3 : rate + FREE_VELOCITIES]
            centre, _ = client.getBasePositionAndOrientation(body)
            client.applyExternalForce(body, -1, linear, centre, client.WORLD_FRAME)
            client.applyExternalTorque(body, -1, torque, client.WORLD_FRAME)
        for body, joint, _, rate in self.joints:
            kind = client.TORQUE_CONTROL
            client.setJointMotorControl2(body, joint, kind, force=force[rate])


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
                names.append((self._name(body, link), self._name(other_body, other_link)))
        return names

    def _name(self, body: int, link: int) -> str:
        """The name of a link of a body."""
        client = self.touching.client
        base_name, *_ = client.getBodyInfo(body)
        encoded = base_name if link < 0 else client.getJointInfo(body, link)[12]
        name: str = encoded.decode()
        return name

    def advance(self, control: Array, force: Array, steps: int) -> tuple[Array, Array]:
        """Takes `steps` steps under a generalised `force`, which is held; returns the coordinates
        and their rates. Bullet reads no actuators: the control has no effect."""
        return self.world.advance(force, steps)


def _frame(client: Any, body: int) -> FreeJointFrame:
    """The conversion between the pose of a floating body and Bullet's coordinates, which are the
    place of its centre of mass and its attitude."""
    arm = client.getDynamicsInfo(body, -1)[3]
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
    world = model.world
    client = model.world.client
    hinges = [
        (client.getJointInfo(body, joint)[1].decode(), (q, v))
        for body, joint, q, v in world.joints
    ]
    free = [(q, v, _frame(client, body)) for body, q, v in world.bases]
    return Translated(model, layout, hinges, free, displaced=True)
