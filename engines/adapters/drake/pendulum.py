"""A pendulum as a diagram of Drake: the discrete plant, and the continuous one with an integrator
that controls its error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody import tree
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Sine

from plumbob.engines.adapters.drake.stepping import (
    BROKEN,
    Start,
    by_steps,
    error_controlled,
    spatial_inertia,
)
from plumbob.engines.adapters.hinged_body import HingedBody, hinged_body
from plumbob.engines.adapters.stepping import Built, stepped
from plumbob.engines.method import Method, Simulation
from plumbob.models.scene import Case


def discrete(case: Case, method: Method, step: float) -> Simulation:
    """The discrete plant of a pendulum's case at `step` [s]; raises ParameterError."""
    return stepped(case, step, partial(_pendulum, hinged_body(case), step, by_steps(step)), BROKEN)


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

    def read(self, simulator: Any) -> Mapping[str, float]:
        """Angle [rad] and rate [rad/s]."""
        context = self.plant.GetMyContextFromRoot(simulator.get_context())
        theta, theta_dot = self.hinge.get_angle(context), self.hinge.get_angular_rate(context)
        return {"theta": float(theta), "theta_dot": float(theta_dot)}


def hinged(body: HingedBody, step: float) -> Hinged:
    """The diagram of a pendulum, discrete at `step` [s], or continuous where that is 0."""
    builder = DiagramBuilder()
    # CENIC wants a scene graph beside the plant.
    plant = (
        builder.AddSystem(MultibodyPlant(step))
        if step
        else AddMultibodyPlant(MultibodyPlantConfig(time_step=step), builder)[0]
    )
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


def _pendulum(body: HingedBody, step: float, start: Start) -> Built:
    made = hinged(body, step)
    simulator, advance = start(made.diagram, made.start())
    return Built(advance, partial(made.read, simulator), body.limits)


def continuous(case: Case, method: Method, accuracy: float, smallest: float) -> Simulation:
    """The continuous plant of a pendulum's case with the integrator that `method` names, at an
    accuracy of at least the `smallest`; raises ParameterError."""
    build = partial(_pendulum, hinged_body(case), 0.0)
    return error_controlled(case, method, accuracy, smallest, build)
