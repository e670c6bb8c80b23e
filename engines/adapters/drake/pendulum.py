"""A pendulum as a diagram of Drake: the discrete plant, and the continuous one with an integrator
that controls its error."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody import tree
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Sine

from plumbob.engines.adapters.drake.stepping import (
    BROKEN,
    ErrorControlledSimulation,
    advancing,
    simulator_of,
    spatial_inertia,
)
from plumbob.engines.adapters.hinged_body import HingedBody, hinged_body
from plumbob.engines.adapters.stepping import Built, relative_tolerance, stepped
from plumbob.engines.method import Method, Simulation
from plumbob.models.scene import Case


def discrete(case: Case, step: float) -> Simulation:
    """The discrete plant of a pendulum's case at `step` [s]; raises ParameterError."""
    return stepped(case, step, partial(_discrete_pendulum, hinged_body(case), step), BROKEN)


@dataclass
class Hinged:
    """A pendulum's diagram with its plant and its hinge."""

    diagram: Any
    plant: Any
    hinge: Any
    platform: Any
    body: HingedBody

    def start(self) -> Any:
        """A context at the start of the run."""
        context = self.diagram.CreateDefaultContext()
        plant_context = self.plant.GetMyMutableContextFromRoot(context)
        self.hinge.set_angle(plant_context, self.body.theta)
        self.hinge.set_angular_rate(plant_context, self.body.theta_dot)
        if self.platform is not None:
            self.platform.set_angular_rate(plant_context, self.body.platform_rate)
        return context

    def read(self, context: Any) -> tuple[float, float]:
        """Angle [rad] and rate [rad/s]."""
        plant_context = self.plant.GetMyContextFromRoot(context)
        return float(self.hinge.get_angle(plant_context)), float(
            self.hinge.get_angular_rate(plant_context)
        )


def hinged(body: HingedBody, step: float) -> Hinged:
    """The diagram of a pendulum, discrete at `step` [s], or continuous where that is 0."""
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(step))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -body.gravity])
    parent, platform = plant.world_body(), None
    if body.platform_rate is not None:
        parent = plant.AddRigidBody("platform", spatial_inertia(1.0, np.zeros(3), np.eye(3)))
        platform = plant.AddJoint(
            tree.RevoluteJoint("platform", plant.world_frame(), parent.body_frame(), [0, 0, 1])
        )
        motor = plant.AddJointActuator("platform", platform)
        motor.set_default_rotor_inertia(body.platform_inertia)
        motor.set_default_gear_ratio(1.0)
    centre = np.array([0.0, 0.0, -body.arm])
    bob = plant.AddRigidBody("bob", spatial_inertia(body.mass, centre, body.moments))
    mount = plant.AddFrame(
        tree.FixedOffsetFrame("pivot", parent.body_frame(), RigidTransform(list(body.pivot)))
    )
    hinge = plant.AddJoint(
        tree.RevoluteJoint("theta", mount, bob.body_frame(), [1, 0, 0], damping=body.damping)
    )
    if body.stiffness:
        plant.AddForceElement(tree.RevoluteSpring(hinge, 0.0, body.stiffness))
    if body.forcing is not None:
        plant.AddJointActuator("theta", hinge)
    plant.Finalize()
    if body.forcing is not None:
        source = builder.AddSystem(Sine(*body.forcing, 0.0, 1))
        builder.Connect(source.get_output_port(0), plant.get_actuation_input_port())
    return Hinged(builder.Build(), plant, hinge, platform, body)


def _discrete_pendulum(body: HingedBody, step: float) -> Built:
    made = hinged(body, step)
    simulator = simulator_of(made.diagram, made.start())

    def read() -> Mapping[str, float]:
        theta, theta_dot = made.read(simulator.get_context())
        return {"theta": theta, "theta_dot": theta_dot}

    return Built(advancing(simulator, step), read, body.limits)


def error_controlled(case: Case, method: Method, accuracy: float, smallest: float) -> Simulation:
    """The continuous plant of a pendulum's case with the integrator that `method` names, at an
    accuracy of at least the `smallest`; raises ParameterError."""
    relative_tolerance(accuracy, smallest)
    begin = time.perf_counter()
    made = hinged(hinged_body(case), 0.0)
    seconds = time.perf_counter() - begin
    name, duration = method.settings["integration_scheme"], case.scene.duration
    return ErrorControlledSimulation(made, name, accuracy, duration, seconds)
