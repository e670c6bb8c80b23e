"""The capsule as a diagram of Drake: a discrete plant with point contacts, the slider's motion
imposed step by step."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody import tree
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlantConfig
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource, ZeroOrderHold
from pydrake.trajectories import PiecewisePolynomial

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.drake.stepping import (
    BROKEN,
    Start,
    by_steps,
    error_controlled,
    simulator_of,
    spatial_inertia,
)
from plumbob.engines.adapters.stepping import Built, stepped
from plumbob.engines.adapters.three_feet import (
    FOOT_RADIUS,
    POINT,
    Pose,
    ThreeFeet,
    gravity,
    start_velocity,
    three_feet,
)
from plumbob.engines.method import Method, Simulation
from plumbob.engines.sampling import step_count
from plumbob.models.scene import Case

SLIDER_RATIO = 1e8  # of the slider's to the capsule's mass
GROUND = 100.0  # [m] of a block whose top is the plane
SETTLING = 1000  # steps for the capsule to come to rest on its contacts
SETTLING_STEP = 1e-3  # [s]
CONTROL = 1e-3  # [s] for which the slider's acceleration is held in a continuous plant


def discrete(case: Case, method: Method, step: float) -> Simulation:
    """The capsule of `case` with the contact solver that `method` names, at `step` [s]; raises
    ParameterError."""
    steps = step_count(case.scene.duration, step)
    build = partial(_capsule, three_feet(case), method.settings, step, steps)
    return stepped(case, step, partial(build, by_steps(step)), BROKEN)


def continuous(case: Case, method: Method, accuracy: float, smallest: float) -> Simulation:
    """The continuous plant of `case` with the integrator that `method` names, at an accuracy of at
    least the `smallest`, the slider's motion held for CONTROL; raises ParameterError."""
    steps = step_count(case.scene.duration, CONTROL)
    build = partial(_capsule, three_feet(case), {"time_step": 0.0}, CONTROL, steps)
    return error_controlled(case, method, accuracy, smallest, build)


@dataclass
class _Standing:
    """A capsule's diagram with its plant, its body and the slider's joints."""

    diagram: Any
    plant: Any
    shell: Any
    joints: list[Any]

    def start(self, body: ThreeFeet, rest_pose: tuple[Array, Array]) -> Any:
        """A context at the start of the run, the body at `rest_pose` but for the heading."""

        setup, (attitude, place) = body.setup, rest_pose
        turn = RollPitchYaw(0.0, 0.0, setup.heading).ToRotationMatrix()
        context = self.diagram.CreateDefaultContext()
        plant_context = self.plant.GetMyMutableContextFromRoot(context)
        leaning = RotationMatrix(Quaternion(attitude / np.linalg.norm(attitude)))
        self.plant.SetFreeBodyPose(plant_context, self.shell, RigidTransform(turn @ leaning, place))
        rates = SpatialVelocity([0.0, 0.0, setup.heading_rate], [*start_velocity(setup), 0.0])
        self.plant.SetFreeBodySpatialVelocity(plant_context, self.shell, rates)
        if self.joints:
            begun = body.slider_velocity(np.zeros(1))[0].tolist()
            for joint, value in zip(self.joints, begun, strict=True):
                joint.set_translation_rate(plant_context, value)
        return context

    def pose(self, simulator: Any) -> Pose:
        """The pose in the simulator's context."""
        context = self.plant.GetMyContextFromRoot(simulator.get_context())
        pose = self.plant.EvalBodyPoseInWorld(context, self.shell)
        rates = self.plant.EvalBodySpatialVelocityInWorld(context, self.shell)
        turned, (x, y, z) = pose.rotation().matrix(), pose.translation().tolist()
        vx, vy, _ = rates.translational().tolist()
        slid = [float(joint.get_translation(context)) for joint in self.joints[:1]]
        pace = [float(joint.get_translation_rate(context)) for joint in self.joints[:1]]
        heading = math.atan2(turned[1, 0], turned[0, 0])
        return Pose((x, y), (vx, vy), heading, float(rates.rotational()[2]), z, *slid, *pace)


def _standing(
    body: ThreeFeet,
    settings: Mapping[str, Any],
    step: float,
    gravity: tuple[float, float, float],
    controls: Array,
) -> _Standing:
    """The diagram of a capsule under `gravity`, its slider under `controls` [m/s^2], one row a
    step, shape (steps, tracks)."""
    capsule, builder = body.setup.capsule, DiagramBuilder()
    config = MultibodyPlantConfig(**{"time_step": step, **settings})
    plant, _ = AddMultibodyPlant(config, builder)
    plant.mutable_gravity_field().set_gravity_vector(gravity)
    shell = _shell(plant, body)
    motor = SLIDER_RATIO * (capsule.body_mass + capsule.slider_mass)
    joints = _slider(plant, shell, body, motor)
    plant.Finalize()
    if joints:
        # held over a step: in force from half a step before it begins, where nothing is computed
        times = (np.arange(len(controls) + 1) - 0.5) * step
        rows = np.vstack([controls, controls[-1:]]) * motor
        held = PiecewisePolynomial.ZeroOrderHold(times, rows.T)
        source = builder.AddSystem(TrajectorySource(held))
        if not plant.time_step():  # an integrator's step ends where the control changes
            hold, moves = builder.AddSystem(ZeroOrderHold(step, len(joints))), source
            builder.Connect(moves.get_output_port(0), hold.get_input_port(0))
            source = hold
        builder.Connect(source.get_output_port(0), plant.get_actuation_input_port())
    return _Standing(builder.Build(), plant, shell, joints)


def _shell(plant: Any, body: ThreeFeet) -> Any:
    """The body on its feet, above the plane."""
    capsule = body.setup.capsule
    friction = CoulombFriction(capsule.friction, capsule.friction)
    ground = RigidTransform([0.0, 0.0, -0.5 * GROUND])
    plant.RegisterCollisionGeometry(
        plant.world_body(), ground, Box(GROUND, GROUND, GROUND), "plane", friction
    )
    moments = np.diag([body.tilt_inertia, body.tilt_inertia, capsule.inertia])
    shell = plant.AddRigidBody("body", spatial_inertia(capsule.body_mass, np.zeros(3), moments))
    for number, (x, y) in enumerate(capsule.supports):
        place = RigidTransform([x, y, FOOT_RADIUS])
        foot = Sphere(FOOT_RADIUS)
        plant.RegisterCollisionGeometry(shell, place, foot, f"foot_{number}", friction)
    return shell


def _slider(plant: Any, shell: Any, body: ThreeFeet, hold: float) -> list[Any]:
    """The joints of a slider at its start in the `shell`, one a track, each with a motor of inertia
    `hold` [kg]."""
    start = RigidTransform([*body.setup.slider, 0.0])
    parent = plant.AddFrame(tree.FixedOffsetFrame("start", shell.body_frame(), start))
    last, joints = max(len(body.tracks), 1) - 1, []
    for number, (x, y) in enumerate(body.tracks or ((0.0, 0.0),)):
        mass = body.setup.capsule.slider_mass if number == last else POINT
        inertia = spatial_inertia(mass, np.zeros(3), POINT * np.eye(3))
        part = plant.AddRigidBody(f"slider_{number}", inertia)
        if not body.tracks:
            plant.WeldFrames(parent, part.body_frame())
            break
        joint = plant.AddJoint(
            tree.PrismaticJoint(f"track_{number}", parent, part.body_frame(), [x, y, 0.0])
        )
        motor = plant.AddJointActuator(f"motor_{number}", joint)
        motor.set_default_rotor_inertia(hold)
        motor.set_default_gear_ratio(1.0)
        joints.append(joint)
        parent = part.body_frame()
    return joints


def _capsule(
    body: ThreeFeet, settings: Mapping[str, Any], step: float, steps: int, start: Start
) -> Built:
    standing = _standing(
        body,
        settings,
        step,
        gravity(body.setup),
        body.accelerations(0, steps, step) if body.tracks else np.zeros((0, 0)),
    )
    rest = _rest(body, {**settings, "time_step": SETTLING_STEP})
    simulator, advance = start(standing.diagram, standing.start(body, rest))
    return body.built(advance, partial(standing.pose, simulator))


def _rest(body: ThreeFeet, settings: Mapping[str, Any]) -> tuple[Array, Array]:
    """Attitude, a quaternion, and place of a body that rests on its contacts, which yield."""
    still = np.zeros((SETTLING, len(body.tracks)))
    standing = _standing(body, settings, SETTLING_STEP, (0.0, 0.0, -body.setup.press), still)
    context = standing.diagram.CreateDefaultContext()
    simulator = simulator_of(standing.diagram, context)
    simulator.AdvanceTo(SETTLING * SETTLING_STEP)
    plant_context = standing.plant.GetMyContextFromRoot(simulator.get_context())
    pose = standing.plant.EvalBodyPoseInWorld(plant_context, standing.shell)
    attitude = pose.rotation().ToQuaternion().wxyz()
    attitude[3] = 0.0
    return attitude, np.array([0.0, 0.0, pose.translation()[2]])
