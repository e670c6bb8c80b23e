"""A user's model file as Bullet reads it. Its terms are those that its steps show: accelerations in
a very short step, without contacts, from rest, under a force on one coordinate at a time, and with
the velocity. Its own inverse dynamics counts joints that are fixed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.peer_model import FREE, Frame, Layout, NotRead, PeerModel, Translated, rotation

PROBE = 1e-6  # [s] of the step that shows accelerations
DAMPED = "springs and damping dropped; velocities of links damped by Bullet's default"
WIDE = 1e10  # limits of joints that act on nothing
FRAME = Frame(lambda p, r: np.concatenate([p, r]), lambda q: (q[:3], q[3:]), linear_first=True)


@dataclass(frozen=True)
class Tree:
    """A body that moves, and its joints of one degree of freedom."""

    body: int
    joints: tuple[int, ...]
    free: bool  # its base
    centre: Array  # [m] of the base's mass in the base
    q: int  # where its coordinates begin
    v: int


class World:
    """A file in a simulation of its own, without motors."""

    def __init__(self, path: Path, step: float) -> None:
        import pybullet
        from pybullet_utils.bullet_client import BulletClient

        self.client = BulletClient(connection_mode=pybullet.DIRECT)
        self.bodies = self.client.loadMJCF(str(path))
        self.client.setPhysicsEngineParameter(fixedTimeStep=step, deterministicOverlappingPairs=1)
        self.step = step
        for body, link in self.links():
            if link >= 0:
                kind = self.client.VELOCITY_CONTROL
                self.client.setJointMotorControl2(body, link, kind, force=0.0)

    def links(self) -> list[tuple[int, int]]:
        """Each body with its links, the base first."""
        return [(b, i) for b in self.bodies for i in range(-1, self.client.getNumJoints(b))]

    def without_contacts(self, damped: bool) -> World:
        """Changed in place: nothing touches or meets a limit, and velocities are damped or not."""
        none = {} if damped else {"linearDamping": 0.0, "angularDamping": 0.0, "jointDamping": 0.0}
        for body, link in self.links():
            self.client.setCollisionFilterGroupMask(body, link, 0, 0)
            limits = {"jointLowerLimit": -WIDE, "jointUpperLimit": WIDE} if link >= 0 else {}
            self.client.changeDynamics(body, link, **none, **limits)
        return self

    def put(self, trees: Sequence[Tree], q: Array, v: Array) -> None:
        """Start from these coordinates."""
        for tree in trees:
            at, rate = tree.q, tree.v
            if tree.free:
                attitude = q[at + 3 : at + 7]
                arm, spin = rotation(attitude) @ tree.centre, v[rate + 3 : rate + 6]
                place, speed = q[at : at + 3] + arm, v[rate : rate + 3] + np.cross(spin, arm)
                self.client.resetBasePositionAndOrientation(tree.body, place, np.roll(attitude, -1))
                self.client.resetBaseVelocity(tree.body, speed, spin)
                at, rate = at + 7, rate + FREE
            for k, joint in enumerate(tree.joints):
                self.client.resetJointState(tree.body, joint, q[at + k], v[rate + k])

    def got(self, trees: Sequence[Tree]) -> tuple[Array, Array]:
        """The coordinates."""
        q, v = list[float](), list[float]()
        for tree in trees:
            if tree.free:
                place, attitude = self.client.getBasePositionAndOrientation(tree.body)
                speed, spin = self.client.getBaseVelocity(tree.body)
                turned = np.roll(attitude, 1)
                arm = rotation(turned) @ tree.centre
                q += [*(place - arm), *turned]
                v += [*(speed - np.cross(spin, arm)), *spin]
            states = self.client.getJointStates(tree.body, tree.joints) if tree.joints else ()
            q += [state[0] for state in states]
            v += [state[1] for state in states]
        return np.array(q), np.array(v)

    def advance(self, trees: Sequence[Tree], force: Array | None) -> None:
        """Take a step."""
        client = self.client
        for tree in trees:
            if force is None:
                break
            at = tree.v
            if tree.free:
                place, attitude = client.getBasePositionAndOrientation(tree.body)
                arm = rotation(np.roll(attitude, 1)) @ tree.centre
                push, turn = force[at : at + 3], force[at + 3 : at + FREE]
                torque = turn - np.cross(arm, push)
                client.applyExternalForce(tree.body, -1, push, place, client.WORLD_FRAME)
                client.applyExternalTorque(tree.body, -1, torque, client.WORLD_FRAME)
                at += FREE
            forces = force[at : at + len(tree.joints)]
            kind = client.TORQUE_CONTROL
            client.setJointMotorControlArray(tree.body, tree.joints, kind, forces=forces)
        client.stepSimulation()


class BulletModel:
    """A file in Bullet, to be stepped, and to be looked at without contacts and damping."""

    def __init__(self, path: Path, layout: Layout, step: float) -> None:
        self.world, self.looked_at = World(path, step), World(path, PROBE)
        self.bare = World(path, PROBE).without_contacts(damped=False)
        self.damped = World(path, PROBE).without_contacts(damped=True)
        floating = sum(joint.size == FREE for joint in layout.joints)
        self.trees, self.hinges, q, v = list[Tree](), dict[str, tuple[int, int]](), 0, 0
        client = self.world.client
        for body in self.world.bodies:
            infos = [client.getJointInfo(body, i) for i in range(client.getNumJoints(body))]
            moving = [i for i in infos if i[2] != client.JOINT_FIXED]
            if any(i[2] not in (client.JOINT_REVOLUTE, client.JOINT_PRISMATIC) for i in moving):
                raise NotRead("it has a joint of a kind that is not compared")
            mass, _, _, centre, *_ = client.getDynamicsInfo(body, -1)
            free = mass > 0.0 and floating > 0
            floating -= free
            tree = Tree(body, tuple(i[0] for i in moving), free, np.array(centre), q, v)
            q, v = q + 7 * free, v + FREE * free
            self.hinges |= {i[1].decode(): (q + k, v + k) for k, i in enumerate(moving)}
            q, v = q + len(moving), v + len(moving)
            self.trees.append(tree)
        self.size = v

    def put(self, q: Array, v: Array) -> None:
        """Start from these coordinates."""
        self.world.put(self.trees, q, v)

    def _acceleration(self, world: World, q: Array, v: Array, force: Array | None = None) -> Array:
        world.put(self.trees, q, v)
        world.advance(self.trees, force)
        return (world.got(self.trees)[1] - v) / PROBE

    def terms(self, q: Array, v: Array, control: Array) -> dict[str, Any]:
        """As its steps show them; of actuators it reads none."""
        rest = np.zeros(self.size)
        falls = self._acceleration(self.bare, q, rest)
        columns = [self._acceleration(self.bare, q, rest, unit) - falls for unit in np.eye(len(v))]
        inertia = np.linalg.inv(np.array(columns).T)
        moved = self._acceleration(self.bare, q, v)
        damped = self._acceleration(self.damped, q, v)
        return {
            "mass matrix": (inertia + inertia.T) / 2,
            "gravity": inertia @ falls,
            "bias": inertia @ (falls - moved),
            "passive": inertia @ (damped - moved),
            "actuator": rest,
            "contacts": self._touching(q, v),
            "causes": {"passive": DAMPED},
        }

    def _touching(self, q: Array, v: Array) -> list[tuple[str, ...]]:
        client = self.looked_at.client
        self.looked_at.put(self.trees, q, v)
        client.performCollisionDetection()
        points = [point for point in client.getContactPoints() or () if point[8] <= 0.0]
        return [(self._name(*point[1:4:2]), self._name(*point[2:5:2])) for point in points]

    def _name(self, body: int, link: int) -> str:
        client = self.looked_at.client
        info = client.getBodyInfo(body)[0] if link < 0 else client.getJointInfo(body, link)[12]
        name: str = info.decode()
        return name

    def advance(self, control: Array, force: Array | None, steps: int) -> tuple[Array, Array]:
        """Take steps."""
        for _ in range(steps):
            self.world.advance(self.trees, force)
        return self.world.got(self.trees)


def user_model(path: Path, layout: Layout, step: float) -> PeerModel:
    """The model of a file; raises NotRead, and pybullet.error where Bullet refuses the file."""
    model = BulletModel(path, layout, step)
    free = [(tree.q, tree.v, FRAME) for tree in model.trees if tree.free]
    return Translated(model, layout, model.hinges, free, displaced=True)
