"""A scene as a diagram of Drake: a chain of bodies in a discrete plant, or in a continuous one with
an integrator that controls its error; the capsule with point contacts, its slider's motion imposed
step by step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody import tree
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Sine, TrajectorySource, ZeroOrderHold
from pydrake.trajectories import PiecewisePolynomial

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.chain import FREE, HINGE, WELD, Link, Vector
from plumbob.engines.adapters.drake.stepping import (
    BROKEN,
    Scene,
    by_steps,
    error_controlled,
    simulator_of,
)
from plumbob.engines.adapters.hinged_body import HingedBody, hinged_body
from plumbob.engines.adapters.stepping import Built, TakeSteps, stepped
from plumbob.engines.adapters.three_feet import (
    CAPSULE,
    FOOT_RADIUS,
    Pose,
    ThreeFeet,
    gravity,
    on_three_feet,
    start_velocity,
)
from plumbob.engines.method import Method, Options, Simulation
from plumbob.engines.sampling import step_count
from plumbob.engines.trajectory import ByName
from plumbob.models.scene import Case

GROUND = 100.0  # [m] of a block whose top is the plane
SETTLING = 1000  # steps for the capsule to come to rest on its contacts
SETTLING_STEP = 1e-3  # [s]
CONTROL = 1e-3  # [s] for which the slider's acceleration is held in a continuous plant


def discrete(case: Case, method: Method, step: float) -> Simulation:
    """The discrete plant of `case` with the contact solver that `method` names, at `step` [s];
    raises Unsupported and ParameterError."""
    scene = _scene(case, method.settings, step, step)
    return stepped(case, step, partial(by_steps, scene, step), BROKEN)


def continuous(case: Case, method: Method, accuracy: float, smallest: float) -> Simulation:
    """The continuous plant of `case` with the integrator that `method` names, at an accuracy of at
    least the `smallest`, a slider's motion held for CONTROL; raises ParameterError."""
    return error_controlled(case, method, accuracy, smallest, _scene(case, {}, 0.0, CONTROL))


def _scene(case: Case, settings: Options, step: float, control: float) -> Scene:
    """`case` in a plant of this step [s], 0 if continuous."""
    if case.system.family != CAPSULE:
        return partial(_pendulum, hinged_body(case), step)
    steps = step_count(case.scene.duration, control)
    return partial(
        _capsule, on_three_feet(case.problem.setup), {**settings, "time_step": step}, control, steps
    )


@dataclass
class Standing:
    """A diagram with its plant, the bodies and the joints of a chain."""

    diagram: Any
    plant: Any
    links: tuple[Link, ...]
    bodies: list[Any]
    joints: list[Any]  # None where a body is free or welded to the one before

    def start(self) -> Any:
        """A context in which the joints are at their starts."""
        context = self.diagram.CreateDefaultContext()
        within = self.plant.GetMyMutableContextFromRoot(context)
        for link, joint in zip(self.links, self.joints, strict=True):
            if joint is not None:
                of_hinge = link.joint == HINGE
                (joint.set_angle if of_hinge else joint.set_translation)(within, link.position)
                rate = joint.set_angular_rate if of_hinge else joint.set_translation_rate
                rate(within, link.rate)
        return context

    def on_feet(self, body: ThreeFeet, rest_pose: tuple[Array, Array]) -> Any:
        """A context at the start of a capsule's run, at `rest_pose` but for the heading."""
        setup, (attitude, place), shell = body.setup, rest_pose, self.bodies[0]
        turn = RollPitchYaw(0.0, 0.0, setup.heading).ToRotationMatrix()
        context = self.start()
        within = self.plant.GetMyMutableContextFromRoot(context)
        leaning = RotationMatrix(Quaternion(attitude / np.linalg.norm(attitude)))
        self.plant.SetFreeBodyPose(within, shell, RigidTransform(turn @ leaning, place))
        rates = SpatialVelocity([0.0, 0.0, setup.heading_rate], [*start_velocity(setup), 0.0])
        self.plant.SetFreeBodySpatialVelocity(within, shell, rates)
        return context

    def angle(self, simulator: Any) -> ByName:
        """Angle [rad] and rate [rad/s] of the last hinge."""
        context, hinge = self._context(simulator), self.joints[-1]
        theta, theta_dot = hinge.get_angle(context), hinge.get_angular_rate(context)
        return {"theta": float(theta), "theta_dot": float(theta_dot)}

    def pose(self, simulator: Any) -> Pose:
        """The pose of a capsule in the simulator's context."""
        context, shell = self._context(simulator), self.bodies[0]
        pose = self.plant.EvalBodyPoseInWorld(context, shell)
        rates = self.plant.EvalBodySpatialVelocityInWorld(context, shell)
        turned, (x, y, _) = pose.rotation().matrix(), pose.translation().tolist()
        vx, vy, _ = rates.translational().tolist()
        slide = self.joints[1]
        slid = slide and (slide.get_translation(context), slide.get_translation_rate(context))
        heading = math.atan2(turned[1, 0], turned[0, 0])
        turning = float(rates.rotational()[2])
        return Pose(complex(x, y), complex(vx, vy), heading, turning, *map(float, slid or ()))

    def _context(self, simulator: Any) -> Any:
        return self.plant.GetMyContextFromRoot(simulator.get_context())


def _jointed(plant: Any, links: tuple[Link, ...]) -> tuple[list[Any], list[Any]]:
    """The bodies of a chain, and their joints; one whose motion is prescribed has a motor."""
    before, bodies, joints = plant.world_frame(), list[Any](), list[Any]()
    for number, link in enumerate(links):
        bodies.append(plant.AddRigidBody(f"body_{number}", _inertia(link)))
        joints.append(None)
        frame, offset = bodies[-1].body_frame(), RigidTransform(list(link.place))
        if link.joint != FREE:
            mount = plant.AddFrame(tree.FixedOffsetFrame(f"mount_{number}", before, offset))
            if link.joint == WELD:
                plant.WeldFrames(mount, frame)
            else:
                kind = tree.RevoluteJoint if link.joint == HINGE else tree.PrismaticJoint
                joint = kind(f"joint_{number}", mount, frame, link.axis, damping=link.damping)
                joints[-1] = plant.AddJoint(joint)
        if link.stiffness:
            plant.AddForceElement(tree.RevoluteSpring(joints[-1], 0.0, link.stiffness))
        if link.hold:
            motor = plant.AddJointActuator(f"motor_{number}", joints[-1])
            motor.set_default_rotor_inertia(link.hold)
            motor.set_default_gear_ratio(1.0)
        before = frame
    return bodies, joints


def _inertia(link: Link) -> Any:
    moments = link.moments
    (xx, yy, zz), (xy, xz, yz) = np.diag(moments), moments[np.triu_indices(3, 1)]
    about = tree.RotationalInertia(xx, yy, zz, xy, xz, yz)
    return tree.SpatialInertia.MakeFromCentralInertia(link.mass, link.centre, about)


def hinged(body: HingedBody, step: float) -> Standing:
    """The diagram of a pendulum, discrete at `step` [s], or continuous where that is 0."""
    builder = DiagramBuilder()
    # CENIC wants a scene graph beside the plant.
    plant = (
        builder.AddSystem(MultibodyPlant(step))
        if step
        else AddMultibodyPlant(MultibodyPlantConfig(time_step=step), builder)[0]
    )
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -body.gravity])
    bodies, joints = _jointed(plant, body.links)
    if body.forcing is not None:
        plant.AddJointActuator("theta", joints[-1])
    plant.Finalize()
    if body.forcing is not None:
        source = builder.AddSystem(Sine(*body.forcing, 0.0, 1))
        builder.Connect(source.get_output_port(0), plant.get_actuation_input_port())
    return Standing(builder.Build(), plant, body.links, bodies, joints)


def _pendulum(body: HingedBody, step: float) -> Any:
    standing = hinged(body, step)

    def build(simulator: Any, advance: TakeSteps) -> Built:
        return Built(advance, partial(standing.angle, simulator), body.limits)

    return standing.diagram, standing.start(), build


def _standing(
    body: ThreeFeet,
    settings: Options,
    step: float,
    pull: Vector,
    controls: Array,
) -> Standing:
    """The diagram of a capsule under gravity, its slider under `controls` [m/s^2], one row a step,
    shape (steps, tracks)."""
    capsule, builder = body.setup.capsule, DiagramBuilder()
    plant, _ = AddMultibodyPlant(MultibodyPlantConfig(**settings), builder)
    plant.mutable_gravity_field().set_gravity_vector(pull)
    friction = CoulombFriction(capsule.friction, capsule.friction)
    bodies, joints = _jointed(plant, body.links)
    ground = RigidTransform([0.0, 0.0, -0.5 * GROUND])
    block = Box(GROUND, GROUND, GROUND)
    plant.RegisterCollisionGeometry(plant.world_body(), ground, block, "plane", friction)
    for number, (x, y) in enumerate(capsule.supports):
        place, foot = RigidTransform([x, y, FOOT_RADIUS]), Sphere(FOOT_RADIUS)
        plant.RegisterCollisionGeometry(bodies[0], place, foot, f"foot_{number}", friction)
    plant.Finalize()
    if body.tracks:
        _drive(builder, plant, controls * body.hold, step)
    return Standing(builder.Build(), plant, body.links, bodies, joints)


def _drive(builder: Any, plant: Any, forces: Array, step: float) -> None:
    """Hold the forces of the motors over a step, from half a step before it begins, where nothing
    is computed."""
    times = (np.arange(len(forces) + 1) - 0.5) * step
    held = PiecewisePolynomial.ZeroOrderHold(times, np.vstack([forces, forces[-1:]]).T)
    source = builder.AddSystem(TrajectorySource(held))
    if not plant.time_step():  # an integrator's step ends where the control changes
        hold, moves = builder.AddSystem(ZeroOrderHold(step, forces.shape[1])), source
        builder.Connect(moves.get_output_port(0), hold.get_input_port(0))
        source = hold
    builder.Connect(source.get_output_port(0), plant.get_actuation_input_port())


def _capsule(body: ThreeFeet, settings: Options, step: float, steps: int) -> Any:
    controls = (
        body.accelerations(np.arange(float(steps)), step) if body.tracks else np.zeros((0, 0))
    )
    standing = _standing(body, settings, step, gravity(body.setup), controls)
    rest = _rest(body, {**settings, "time_step": SETTLING_STEP})

    def build(simulator: Any, advance: TakeSteps) -> Built:
        return body.built(advance, partial(standing.pose, simulator))

    return standing.diagram, standing.on_feet(body, rest), build


def _rest(body: ThreeFeet, settings: Options) -> tuple[Array, Array]:
    """Attitude, a quaternion, and place of a body that rests on its contacts, which yield."""
    still = np.zeros((SETTLING, len(body.tracks)))
    standing = _standing(body, settings, SETTLING_STEP, (0.0, 0.0, -body.setup.press), still)
    simulator = simulator_of(standing.diagram, standing.diagram.CreateDefaultContext())
    simulator.AdvanceTo(SETTLING * SETTLING_STEP)
    plant_context = standing.plant.GetMyContextFromRoot(simulator.get_context())
    pose = standing.plant.EvalBodyPoseInWorld(plant_context, standing.bodies[0])
    attitude = pose.rotation().ToQuaternion().wxyz()
    attitude[3] = 0.0
    return attitude, np.array([0.0, 0.0, pose.translation()[2]])
