"""A scene as a diagram of Drake: a chain of bodies in a discrete plant, or in a continuous one with
an integrator that controls its error; the capsule with point contacts, its slider's motion imposed
step by step."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
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
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Sine, TrajectorySource, ZeroOrderHold
from pydrake.trajectories import PiecewisePolynomial

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.engines.adapters.chain import FREE, HINGE, WELD, Link, Vector
from plumbob.engines.adapters.stepping import (
    Built,
    Followed,
    FollowedSimulation,
    TakeSteps,
    relative_tolerance,
    stepped,
)
from plumbob.engines.adapters.three_feet import (
    FOOT_RADIUS,
    Bodies,
    ThreeFeet,
    bodies,
)
from plumbob.engines.method import Method, Options, Simulation
from plumbob.engines.sampling import step_count
from plumbob.models.scene import Case
from plumbob.models.tripod_capsule.observed import Pose, start_velocity

BROKEN = (OverflowError, ValueError, RuntimeError)  # raised where numbers are no longer finite
GROUND = 100.0  # [m] of a block whose top is the plane
SETTLING = 1000  # steps for the capsule to come to rest on its contacts
SETTLING_STEP = 1e-3  # [s]
CONTROL = 1e-3  # [s] for which the slider's acceleration is held in a continuous plant


def discrete(case: Case, method: Method, step: float) -> Simulation:
    """The discrete plant of `case` with the contact solver that `method` names, at `step` [s];
    raises Unsupported and ParameterError."""
    body = bodies(case)
    settings = {**method.settings, "time_step": step}

    def build() -> Built:
        simulator, pose = _started(body, settings, step, case.scene.duration)
        return body.built(advancing(simulator, step), pose)

    return stepped(case, step, build, BROKEN)


def continuous(case: Case, method: Method, accuracy: float, smallest: float) -> Simulation:
    """The continuous plant of `case` with the integrator that `method` names, at an accuracy of at
    least the `smallest`, a slider's motion held for CONTROL; raises ParameterError."""
    body = bodies(case)
    lasting = case.scene.duration
    chosen = SimulatorConfig(
        integration_scheme=method.settings["integration_scheme"],
        accuracy=relative_tolerance(accuracy, smallest),
        max_step_size=lasting,
        use_error_control=True,
        target_realtime_rate=0.0,
    )

    def started(step: float) -> tuple[Any, Built]:
        simulator, pose = _started(body, {"time_step": 0.0}, CONTROL, lasting)
        ApplySimulatorConfig(chosen, simulator)
        simulator.Initialize()
        return simulator, body.built(lambda first, last: simulator.AdvanceTo(last * step), pose)

    def follow(duration: float, samples: int) -> Followed:
        step = duration / samples
        simulator, built = started(step)
        rows = [built.read()]
        why = list[str]()
        try:
            for k in range(samples):
                built.advance(k, k + 1)
                rows.append(built.read())
        except BROKEN as error:
            why.append(" ".join(str(error).split()))
        observed, _ = built.gather(rows)
        times = np.asarray(step * np.arange(len(rows)))
        return Followed(times, observed, _evaluations(simulator), not why, tuple(why))

    begin = time.perf_counter()
    limits = started(lasting)[1].limits
    return FollowedSimulation(
        follow, dict, lasting, time.perf_counter() - begin, limits, case.samples
    )


def _started(
    body: Bodies, settings: Options, control: float, duration: float
) -> tuple[Any, Callable[[], Pose]]:
    """A simulator of bodies at their start in a plant with these settings, its controls held so
    long [s], and what tells their pose."""
    source = None
    if isinstance(body, ThreeFeet) and body.tracks:
        steps = np.arange(float(step_count(duration, control)))
        source = _held(body.hold * body.controls(steps, control), control)
    standing = assembled(body, settings, body.pull, source, control)
    still = _rest(body, settings) if isinstance(body, ThreeFeet) else None
    simulator = simulator_of(standing.diagram, standing.start(still))
    return simulator, partial(standing.pose, simulator)


def simulator_of(diagram: Any, context: Any) -> Any:
    """Of a diagram from a context on."""
    simulator = Simulator(diagram, context)
    simulator.set_target_realtime_rate(0.0)
    simulator.Initialize()
    return simulator


def advancing(simulator: Any, step: float) -> TakeSteps:
    """A function that takes the steps with these indices, the last one excluded, of `step` [s]."""

    def advance(first: int, last: int) -> None:
        # A discrete update takes place at the time at which its step begins.
        simulator.AdvanceTo((last - 0.5) * step)

    return advance


@dataclass
class Standing:
    """A diagram with its plant, the bodies and the joints of a chain."""

    diagram: Any
    plant: Any
    body: Bodies
    bodies: list[Any]
    joints: list[Any]  # None where a body is free or welded to the one before

    def start(self, rest_pose: tuple[Array, Array] | None = None) -> Any:
        """A context in which the joints are at their starts, and the body, if free, at `rest_pose`
        but for the heading."""
        context = self.diagram.CreateDefaultContext()
        within = self.plant.GetMyMutableContextFromRoot(context)
        q, v = (
            np.array(get(within)) for get in (self.plant.GetPositions, self.plant.GetVelocities)
        )
        for link, joint in zip(self.body.links, self.joints, strict=True):
            if joint is not None:
                q[joint.position_start()] = link.position
                v[joint.velocity_start()] = link.rate
        self.plant.SetPositions(within, q)
        self.plant.SetVelocities(within, v)
        if rest_pose is not None:
            assert isinstance(self.body, ThreeFeet)
            setup = self.body.setup
            (attitude, place) = rest_pose
            shell = self.bodies[0]
            turn = RollPitchYaw(0.0, 0.0, setup.heading).ToRotationMatrix()
            leaning = RotationMatrix(Quaternion(attitude / np.linalg.norm(attitude)))
            self.plant.SetFreeBodyPose(within, shell, RigidTransform(turn @ leaning, place))
            rates = SpatialVelocity(
                [0.0, 0.0, setup.heading_rate], [*start_velocity(setup), 0.0]
            )
            self.plant.SetFreeBodySpatialVelocity(within, shell, rates)
        return context

    def pose(self, simulator: Any) -> Pose:
        """The pose in the simulator's context."""
        context = self.plant.GetMyContextFromRoot(simulator.get_context())
        first = self.bodies[0]
        pose = self.plant.EvalBodyPoseInWorld(context, first)
        rates = self.plant.EvalBodySpatialVelocityInWorld(context, first)
        turned = pose.rotation().matrix()
        (x, y, _) = pose.translation().tolist()
        vx, vy, _ = rates.translational().tolist()
        heading = math.atan2(turned[1, 0], turned[0, 0])
        last = self.joints[-1]
        moved = last and (last.GetOnePosition(context), last.GetOneVelocity(context))
        turning = float(rates.rotational()[2])
        return Pose(complex(x, y), complex(vx, vy), heading, turning, *map(float, moved or ()))


def _jointed(plant: Any, links: tuple[Link, ...]) -> tuple[list[Any], list[Any]]:
    """The bodies of a chain, and their joints; one whose motion is prescribed has a motor."""
    before = plant.world_frame()
    bodies = list[Any]()
    joints = list[Any]()
    for number, link in enumerate(links):
        bodies.append(plant.AddRigidBody(f"body_{number}", _inertia(link)))
        joints.append(None)
        frame = bodies[-1].body_frame()
        offset = RigidTransform(list(link.place))
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
    (xx, yy, zz) = np.diag(moments)
    (xy, xz, yz) = moments[np.triu_indices(3, 1)]
    about = tree.RotationalInertia(xx, yy, zz, xy, xz, yz)
    return tree.SpatialInertia.MakeFromCentralInertia(link.mass, link.centre, about)


def assembled(
    body: Bodies, settings: Options, pull: Vector, source: Any = None, control: float = 0.0
) -> Standing:
    """The diagram of bodies under gravity [m/s^2], a capsule's motors driven by a `source`, whose
    values an integrator holds for `control` [s]."""
    builder = DiagramBuilder()
    on_feet = isinstance(body, ThreeFeet)
    # Contacts and CENIC want a scene graph beside the plant.
    plant = (
        AddMultibodyPlant(MultibodyPlantConfig(**settings), builder)[0]
        if on_feet or not settings["time_step"]
        else builder.AddSystem(MultibodyPlant(**settings))
    )
    plant.mutable_gravity_field().set_gravity_vector(pull)
    nodes, joints = _jointed(plant, body.links)
    if isinstance(body, ThreeFeet):
        _on_plane(plant, nodes[0], body.setup.capsule)
    elif body.forcing:
        plant.AddJointActuator("theta", joints[-1])
        source = Sine(*body.forcing, 0.0, 1)
    plant.Finalize()
    if source:
        source = builder.AddSystem(source)
        if on_feet and not plant.time_step():  # its step ends where the control changes
            hold = builder.AddSystem(ZeroOrderHold(control, body.driven))
            moves = source
            builder.Connect(moves.get_output_port(0), hold.get_input_port(0))
            source = hold
        builder.Connect(source.get_output_port(0), plant.get_actuation_input_port())
    return Standing(builder.Build(), plant, body, nodes, joints)


def _on_plane(plant: Any, shell: Any, capsule: Capsule) -> None:
    """Add the plane and a capsule's feet."""
    friction = CoulombFriction(capsule.friction, capsule.friction)
    ground = RigidTransform([0.0, 0.0, -0.5 * GROUND])
    block = Box(GROUND, GROUND, GROUND)
    plant.RegisterCollisionGeometry(plant.world_body(), ground, block, "plane", friction)
    for number, (x, y) in enumerate(capsule.supports):
        place = RigidTransform([x, y, FOOT_RADIUS])
        foot = Sphere(FOOT_RADIUS)
        plant.RegisterCollisionGeometry(shell, place, foot, f"foot_{number}", friction)


def _held(forces: Array, step: float) -> Any:
    """The forces of motors, one row a step, held over it from half a step before it begins, where
    nothing is computed."""
    times = (np.arange(len(forces) + 1) - 0.5) * step
    held = PiecewisePolynomial.ZeroOrderHold(times, np.vstack([forces, forces[-1:]]).T)
    return TrajectorySource(held)


def _rest(body: ThreeFeet, settings: Options) -> tuple[Array, Array]:
    """Attitude, a quaternion, and place of a body that rests on its contacts, which yield."""
    still = _held(np.zeros((SETTLING, body.driven)), SETTLING_STEP) if body.driven else None
    chosen = {**settings, "time_step": SETTLING_STEP}
    standing = assembled(body, chosen, (0.0, 0.0, -body.setup.press), still)
    simulator = simulator_of(standing.diagram, standing.diagram.CreateDefaultContext())
    simulator.AdvanceTo(SETTLING * SETTLING_STEP)
    plant_context = standing.plant.GetMyContextFromRoot(simulator.get_context())
    pose = standing.plant.EvalBodyPoseInWorld(plant_context, standing.bodies[0])
    attitude = pose.rotation().ToQuaternion().wxyz()
    attitude[3] = 0.0
    return attitude, np.array([0.0, 0.0, pose.translation()[2]])


def _evaluations(simulator: Any) -> int:
    """So far; of CENIC, which counts none, its solutions of a step: three each, rejected ones
    too."""
    integrator = simulator.get_integrator()
    if counted := integrator.get_num_derivative_evaluations():
        return int(counted)
    rejected = integrator.get_num_step_shrinkages_from_error_control()
    return int(3 * (integrator.get_num_steps_taken() + rejected))
