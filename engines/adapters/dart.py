"""DART as an engine: articulated bodies in double precision, semi-implicit Euler, and a slider that
its acceleration actuator drives as prescribed.

Contacts are exact complementarity. By default friction is a box, of which the axes lie along the
world's; the manual's NSGS solver, with its law of Coulomb and a small tolerance, has cones.
"""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.abilities import Fields, ModelReader, RunsFiles, SchemeOfCase
from plumbob.engines.adapters.chain import HINGE, SLIDE, Link, Vector, by_step
from plumbob.engines.adapters.hinged_body import PENDULUMS, model_error
from plumbob.engines.adapters.stepping import Built, stepped
from plumbob.engines.adapters.three_feet import (
    CAPSULES,
    FOOT_RADIUS,
    Bodies,
    ThreeFeet,
    bodies,
    scheme,
)
from plumbob.engines.method import Engine, Method, Simulation
from plumbob.engines.peer_model import (
    FREE,
    Frame,
    Layout,
    NotRead,
    PeerModel,
    RefusedFile,
    Translated,
)
from plumbob.models.border import border
from plumbob.models.scene import Case
from plumbob.models.tripod_capsule.observed import Pose, start_velocity

EULER_STEP = Scheme(EULER, "start", implicit_damping=True, implicit_spring=True)
METHODS = (
    Method("dart/default", EULER_STEP, 1, systems=CAPSULES, kinds=PENDULUMS),
    Method(
        "dart/nsgs",
        EULER_STEP,
        1,
        settings={"tolerance": 1e-8},
        systems=(*CAPSULES, "!*/heavy-slider"),  # whose iterations take minutes
    ),
)
OF_WORLD = "__geom_skel__"  # begins the name of a skeleton that is a geom of the world
DEPTH = 1e-9  # [m] that the feet start in the plane: contacts are found where bodies overlap


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Build `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    return stepped(case, step, partial(_built, bodies(case), method, step))


def _built(body: Bodies, method: Method, step: float) -> Built:
    import dartpy

    world = dartpy.simulation.World()
    skeleton = dartpy.dynamics.Skeleton()
    world.setTimeStep(step)
    world.setGravity(body.pull)
    if method.settings:
        solver = dartpy.constraint.NsgsFrictionSolver()
        chosen = solver.getOptions()
        chosen.tolerance = method.settings["tolerance"]
        solver.setOptions(chosen)
        world.getConstraintSolver().setBoxedLcpSolver(solver)
        awake = dartpy.simulation.DeactivationOptions()
        awake.mEnabled = False
        world.setDeactivationOptions(awake)
    pairs = _jointed(skeleton, body.links)
    if isinstance(body, ThreeFeet):
        _on_plane(world, *pairs[0], body.setup)
    world.addSkeleton(skeleton)
    joints = [joint for joint, _ in pairs]
    driven = joints[len(joints) - body.driven :]
    move = world.step
    controls = by_step(body.controls, step)

    def advance(first: int, last: int) -> None:
        for _ in range(first, last):
            # Accelerations of joints where these are prescribed, else torques.
            for joint, value in zip(driven, next(controls) if driven else (), strict=True):
                joint.setCommand(0, value)
            move()

    return body.built(advance, partial(_pose, pairs[0][1], joints[-1]))


def _moved(place: Vector) -> Any:
    import dartpy

    transform = dartpy.math.Isometry3()
    transform.set_translation(place)
    return transform


def _jointed(skeleton: Any, links: tuple[Link, ...]) -> list[tuple[Any, Any]]:
    """The joints of a chain at its start, each with its body."""
    import dartpy

    pairs: list[tuple[Any, Any]] = []
    for link in links:
        make = getattr(skeleton, f"create{link.joint.title()}JointAndBodyNodePair")
        joint, node = make(*(pairs[-1][1:] if pairs else ()))
        joint.setTransformFromParentBodyNode(_moved(link.place))
        node.setInertia(dartpy.dynamics.Inertia(link.mass, link.centre, link.moments))
        if link.joint in (HINGE, SLIDE):
            joint.setAxis(link.axis)
            joint.setDampingCoefficient(0, link.damping)
            joint.setSpringStiffness(0, link.stiffness)
            joint.setPosition(0, link.position)
            joint.setVelocity(0, link.rate)
        if link.hold:
            joint.setActuatorType(dartpy.dynamics.ActuatorType.ACCELERATION)
        pairs.append((joint, node))
    return pairs


def _on_plane(world: Any, free: Any, shell: Any, setup: CapsuleSetup) -> None:
    """Put the plane into a world, and a capsule onto it at its start."""
    import dartpy

    ground = dartpy.dynamics.Skeleton()
    _, plane = ground.createWeldJointAndBodyNodePair()
    _touching(plane, dartpy.dynamics.PlaneShape([0.0, 0.0, 1.0], 0.0), setup.capsule.friction)
    for x, y in setup.capsule.supports:
        foot = _touching(
            shell, dartpy.dynamics.SphereShape(FOOT_RADIUS), setup.capsule.friction
        )
        foot.setRelativeTransform(_moved((x, y, FOOT_RADIUS)))
    free.setPositions([0.0, 0.0, setup.heading, 0.0, 0.0, -DEPTH])
    # DART's free joint has its rates in the world's axes
    free.setVelocities([0.0, 0.0, setup.heading_rate, *start_velocity(setup), 0.0])
    world.addSkeleton(ground)


def _touching(node: Any, shape: Any, friction: float) -> Any:
    shape_node = node.createShapeNode(shape)
    shape_node.createCollisionAspect()
    shape_node.createDynamicsAspect().setFrictionCoeff(friction)
    return shape_node


def _pose(first: Any, joint: Any) -> Pose:
    transform = first.getWorldTransform()
    (x, y, _) = transform.translation().ravel()
    turned = transform.rotation()
    vx, vy, _ = first.getLinearVelocity().ravel()
    return Pose(
        complex(x, y),
        complex(vx, vy),
        math.atan2(turned[1, 0], turned[0, 0]),
        float(first.getAngularVelocity().ravel()[2]),
        *((joint.getPosition(0), joint.getVelocity(0)) if joint.getNumDofs() else ()),
    )


def _read(path: Path) -> Any:
    """The world of a file; raises RefusedFile."""
    import dartpy

    with border(RefusedFile):
        world = dartpy.utils.MjcfParser.readWorld(str(path.resolve()))
    if world is None:
        raise NotRead("no world is made of it")
    return world


def model_fields(path: Path) -> Fields:
    """The numbers that DART reads from a model file; raises RefusedFile."""
    world = _read(path)
    yield "gravity", "", world.getGravity()
    yield "timestep", "", world.getTimeStep()
    for skeleton in map(world.getSkeleton, range(world.getNumSkeletons())):
        for body in map(skeleton.getBodyNode, range(skeleton.getNumBodyNodes())):
            if not skeleton.getName().startswith(OF_WORLD):
                moments = np.linalg.eigvalsh(body.getInertia().getMoment())
                yield "mass", body.getName(), body.getMass()
                yield "inertia", body.getName(), moments
            for shape in map(body.getShapeNode, range(body.getNumShapeNodes())):
                if shape.hasDynamicsAspect():
                    of_world = skeleton.getName().removeprefix(OF_WORLD)
                    name = of_world if "ShapeNode" in shape.getName() else shape.getName()
                    yield "friction", name, shape.getDynamicsAspect().getFrictionCoeff()
        for dof in map(skeleton.getDof, range(skeleton.getNumDofs())):
            yield "damping", dof.getName(), dof.getDampingCoefficient()
            yield "stiffness", dof.getName(), dof.getSpringStiffness()
            yield "frictionloss", dof.getName(), dof.getCoulombFriction()


class DartModel:
    """The world of a file, its skeletons one after another."""

    def __init__(self, path: Path, step: float) -> None:
        self.world = _read(path)
        self.world.setTimeStep(step)
        skeletons = map(self.world.getSkeleton, range(self.world.getNumSkeletons()))
        self.skeletons = [skeleton for skeleton in skeletons if skeleton.getNumDofs()]
        counts = [skeleton.getNumDofs() for skeleton in self.skeletons]
        self.places = np.cumsum([0, *counts])[:-1].tolist()

    def put(self, q: Array, v: Array) -> None:
        """Start from these coordinates."""
        for skeleton, x, rates in zip(
            self.skeletons, self._split(q), self._split(v), strict=True
        ):
            skeleton.setPositions(x)
            skeleton.setVelocities(rates)

    def _split(self, values: Array) -> list[Array]:
        return np.split(values, self.places[1:])

    def terms(self, q: Array, v: Array, control: Array) -> dict[str, Any]:
        """Of the skeletons; of actuators it reads none."""
        import dartpy
        from scipy.linalg import block_diag

        self.put(q, v)
        all_of = self.skeletons
        dofs = [skeleton.getDof(i) for skeleton in all_of for i in range(skeleton.getNumDofs())]
        damping = np.array([dof.getDampingCoefficient() for dof in dofs])
        springs = [
            dof.getSpringStiffness() * (x - dof.getRestPosition())
            for dof, x in zip(dofs, q, strict=True)
        ]
        touching = dartpy.collision.CollisionResult()
        self.world.checkCollision(dartpy.collision.CollisionOption(), touching)
        return {
            "mass matrix": block_diag(*(skeleton.getMassMatrix() for skeleton in all_of)),
            "gravity": -np.concatenate([skeleton.getGravityForces() for skeleton in all_of]),
            "bias": np.concatenate([skeleton.getCoriolisForces() for skeleton in all_of]),
            "passive": -damping * v - np.array(springs),
            "actuator": np.zeros(len(v)),
            "damping": damping,
            "contacts": [_names(contact) for contact in touching.getContacts()],
        }

    def advance(self, control: Array, force: Array, steps: int) -> tuple[Array, Array]:
        """Take steps."""
        for _ in range(steps):
            for skeleton, part in zip(self.skeletons, self._split(force), strict=True):
                skeleton.setForces(part)
            self.world.step()
        q, v = (
            np.concatenate([getattr(skeleton, name)() for skeleton in self.skeletons])
            for name in ("getPositions", "getVelocities")
        )
        return q, v


def _names(contact: Any) -> tuple[str, ...]:
    """Of the bodies of a contact."""
    shapes = (contact.collisionObject1, contact.collisionObject2)
    nodes = (shape.getShapeFrame().asShapeNode() for shape in shapes)
    return tuple(node.getBodyNodePtr().getName() for node in nodes)


def _frame(joint: Any) -> Frame:
    """Of a free joint, whose coordinates are from where the file draws the body."""
    from scipy.spatial.transform import Rotation

    drawn = joint.getTransformFromParentBodyNode()
    origin = drawn.translation().ravel()
    turned = Rotation.from_matrix(drawn.rotation())

    def pose(place: Array, attitude: Array) -> Array:
        rotation = turned.inv() * Rotation.from_quat(attitude, scalar_first=True)
        return np.concatenate([rotation.as_rotvec(), turned.inv().apply(place - origin)])

    def place(q: Array) -> tuple[Array, Array]:
        attitude = turned * Rotation.from_rotvec(q[:3])
        return origin + turned.apply(q[3:]), attitude.as_quat(scalar_first=True)

    return Frame(pose, place, FREE)


def user_model(path: Path, layout: Layout, step: float) -> PeerModel:
    """The model of a file; raises NotRead."""
    model = DartModel(path, step)
    hinges = []
    free = []
    for skeleton, first in zip(model.skeletons, model.places, strict=True):
        for joint in map(skeleton.getJoint, range(skeleton.getNumJoints())):
            if joint.getNumDofs():
                at = first + joint.getIndexInSkeleton(0)
            if joint.getNumDofs() == 1:
                hinges.append((joint.getName(), (at, at)))  # a name may be there twice
            elif joint.getNumDofs() == FREE:
                free.append((at, at, _frame(joint)))
    return Translated(model, layout, hinges, free, displaced=True)


ENGINE = Engine(
    "dart",
    "dartpy",
    METHODS,
    prepare,
    model_error,
    optional=True,
    abilities=(SchemeOfCase(scheme), ModelReader(model_fields), RunsFiles(user_model)),
)
