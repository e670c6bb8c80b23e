"""PyBullet as an engine: Bullet's multibodies in double precision, semi-implicit Euler, joints and
contacts by sequential impulses.

By default every body's velocity is damped, and the solver stops after 50 iterations or at a
residual of 1e-7; the best that the manual allows has neither. A prescribed motion is a velocity
motor without a limit to its force.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.schemes import EULER, Scheme
from plumbob.engines.abilities import Fields, ModelReader, RunsFiles, SchemeOfCase
from plumbob.engines.adapters.chain import HINGE, SLIDE, Link, Vector, by_step
from plumbob.engines.adapters.hinged_body import PENDULUMS, HingedBody, model_error
from plumbob.engines.adapters.stepping import Built, stepped
from plumbob.engines.adapters.three_feet import (
    FOOT_RADIUS,
    Bodies,
    ThreeFeet,
    bodies,
    scheme,
)
from plumbob.engines.method import Engine, Method, Options, Simulation, Unsupported
from plumbob.engines.peer_model import RefusedFile
from plumbob.models.border import border
from plumbob.models.entry_points import captured
from plumbob.models.scene import Case, later
from plumbob.models.tripod_capsule.observed import Pose, start_velocity

EULER_STEP = Scheme(EULER, "start")
OTHERWISE = Scheme("euler with damping, motors or contacts")  # without a theory here
UNLIMITED = 1e12  # [N] or [N m] of a motor
LINES = ("capsule-line/ca1", "capsule-line/heading-030")
TURNS = ("capsule-turn/light-slider",)
DAMPED = (  # enough to show what the default damping does
    *("simple-pendulum/free-large", "cone-pendulum/rotating-base", "capsule-line/ca1"),
    *("capsule-line/heading-030", "capsule-coast/spin"),
)
ITERATED = MappingProxyType(
    {"numSolverIterations": 200, "solverResidualThreshold": 0.0, "damping": 0.0}
)
METHODS = (
    Method("pybullet/default", OTHERWISE, 1, systems=DAMPED),
    Method(
        "pybullet/undamped+iterated",
        EULER_STEP,
        1,
        settings=ITERATED,
        systems=("!cone-pendulum/fast-platform", *LINES, "capsule-coast", *TURNS),
        kinds=PENDULUMS,
    ),
    Method(
        "pybullet/undamped+pyramid",
        OTHERWISE,
        1,
        settings={**ITERATED, "enableConeFriction": 0},
        systems=("capsule-line/heading-030",),
    ),
)


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Build `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    broken = (OverflowError, ValueError, new_client().error)
    return stepped(case, step, partial(_built, bodies(case), method, step), broken)


def _built(body: Bodies, method: Method, step: float) -> Built:
    if isinstance(body, ThreeFeet):
        return _capsule(body, method, step)
    return _pendulum(body, method, step)


def new_client() -> Any:
    """A client of a simulation of its own, which ends with the last reference to it."""
    with captured():  # what its C code prints
        import pybullet
        from pybullet_utils.bullet_client import BulletClient

        return BulletClient(connection_mode=pybullet.DIRECT)


def _world(pull: Vector, settings: Options, step: float) -> Any:
    client = new_client()
    client.setGravity(*pull)
    chosen = {name: value for name, value in settings.items() if name != "damping"}
    client.setPhysicsEngineParameter(
        fixedTimeStep=step, deterministicOverlappingPairs=1, **chosen
    )
    return client


def _principal(moments: Any) -> tuple[list[float], list[float]]:
    """Principal moments, and the quaternion (x, y, z, w) of their axes."""
    from scipy.spatial.transform import Rotation

    principal, axes = np.linalg.eigh(moments)
    axes[:, 2] *= np.linalg.det(axes)  # right-handed
    return principal.tolist(), Rotation.from_matrix(axes).as_quat().tolist()


def _jointed(client: Any, settings: Options, links: Sequence[Link], **base: Any) -> int:
    """A chain at its start on a `base`, by default one that is fixed; its damping is as the
    settings say, and only joints whose motion is prescribed have motors."""
    count = len(links)
    kinds = {HINGE: client.JOINT_REVOLUTE, SLIDE: client.JOINT_PRISMATIC}
    frames = [_principal(link.moments) for link in links]
    tree: int = client.createMultiBody(
        linkMasses=[link.mass for link in links],
        linkCollisionShapeIndices=[-1] * count,
        linkVisualShapeIndices=[-1] * count,
        linkPositions=[list(link.place) for link in links],
        linkOrientations=[[0, 0, 0, 1]] * count,
        linkInertialFramePositions=[list(link.centre) for link in links],
        linkInertialFrameOrientations=[axes for _, axes in frames],
        linkParentIndices=list(range(count)),
        linkJointTypes=[kinds.get(link.joint, client.JOINT_FIXED) for link in links],
        linkJointAxis=[list(link.axis) for link in links],
        **base,
    )
    damping = settings.get("damping")
    for number in range(-1, count) if damping is not None else ():
        damped = {"linearDamping": damping, "angularDamping": damping, "jointDamping": 0.0}
        client.changeDynamics(tree, number, **damped)
    for number, link in enumerate(links):
        client.changeDynamics(tree, number, localInertiaDiagonal=frames[number][0])
        client.resetJointState(tree, number, link.position, link.rate)
        _motor(client, tree, number, link.rate, UNLIMITED if link.hold else 0.0)
    return tree


def _motor(client: Any, tree: int, joint: int, rate: float, force: float = UNLIMITED) -> None:
    client.setJointMotorControl2(
        tree, joint, client.VELOCITY_CONTROL, targetVelocity=rate, force=force
    )


def _pendulum(body: HingedBody, method: Method, step: float) -> Built:
    client = _world(body.pull, method.settings, step)
    tree = _jointed(client, method.settings, body.links)
    hinge = len(body.links) - 1
    move = client.stepSimulation
    torques = by_step(body.controls, step)
    loaded = bool(body.forcing or body.damping or body.stiffness)

    def advance(first: int, last: int) -> None:
        for _ in range(first, last):
            if loaded:
                theta, rate = client.getJointState(tree, hinge)[:2]
                torque = next(torques)[0] - body.damping * rate - body.stiffness * theta
                client.setJointMotorControl2(tree, hinge, client.TORQUE_CONTROL, force=torque)
            move()

    return body.built(advance, partial(_pose, client, tree, hinge))


def _capsule(body: ThreeFeet, method: Method, step: float) -> Built:
    setup = body.setup
    capsule = body.setup.capsule
    if setup.press <= 0.0:
        raise Unsupported("nothing presses the body onto the plane")
    client = _world(body.pull, method.settings, step)
    ground = client.createMultiBody(0.0, client.createCollisionShape(client.GEOM_PLANE))
    client.changeDynamics(ground, -1, lateralFriction=1.0)  # friction is the product of the two
    feet = client.createCollisionShapeArray(
        shapeTypes=[client.GEOM_SPHERE] * 3,
        radii=[FOOT_RADIUS] * 3,
        collisionFramePositions=[[x, y, FOOT_RADIUS] for x, y in capsule.supports],
    )
    attitude = [0.0, 0.0, math.sin(0.5 * setup.heading), math.cos(0.5 * setup.heading)]
    shell = _jointed(
        client,
        method.settings,
        body.links[1:],
        baseMass=capsule.body_mass,
        baseCollisionShapeIndex=feet,
        baseOrientation=attitude,
    )
    client.changeDynamics(
        shell,
        -1,
        lateralFriction=capsule.friction,
        restitution=0.0,
        localInertiaDiagonal=np.diag(body.links[0].moments).tolist(),
        activationState=1,
    )
    client.resetBaseVelocity(
        shell, [*start_velocity(setup), 0.0], [0.0, 0.0, setup.heading_rate]
    )
    move = client.stepSimulation
    controls = by_step(body.velocities, step)

    def advance(first: int, last: int) -> None:
        for _ in range(first, last):
            for joint, rate in enumerate(next(controls) if body.tracks else ()):
                _motor(client, shell, joint, rate)
            move()

    return body.built(advance, partial(_pose, client, shell, 0 if body.tracks else None))


def _pose(client: Any, tree: int, joint: int | None) -> Pose:
    (x, y, _), attitude = client.getBasePositionAndOrientation(tree)
    (vx, vy, _), (_, _, rate) = client.getBaseVelocity(tree)
    moved = () if joint is None else client.getJointState(tree, joint)[:2]
    heading = client.getEulerFromQuaternion(attitude)[2]
    return Pose(complex(x, y), complex(vx, vy), heading, rate, *moved)


def model_fields(path: Path) -> Fields:
    """The numbers that Bullet reads from a model file; it knows friction by the body, not the geom.
    Raises RefusedFile."""
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
            if mass > 0.0:  # bodies between joints have none
                yield "mass", name, mass
                yield "inertia", name, sorted(moments)
            yield "friction", name, friction


ENGINE = Engine(
    "pybullet",
    "pybullet",
    METHODS,
    prepare,
    model_error,
    optional=True,
    abilities=(
        SchemeOfCase(scheme),
        ModelReader(model_fields),
        RunsFiles(later(f"{__name__}_user_model.user_model")),
    ),
)
