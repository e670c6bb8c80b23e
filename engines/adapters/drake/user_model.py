"""A user's model file in Drake: the numbers that Drake reads from it, and runs of its model in a
discrete plant."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import BodyIndex, PdControllerGains
from pydrake.systems.framework import DiagramBuilder

from plumbob.analytic.reference import Array
from plumbob.engines.abilities import Fields
from plumbob.engines.adapters.drake.stepper import advance, simulator_of
from plumbob.engines.peer_model import (
    FREE_VELOCITIES,
    EngineJoint,
    FreeJointFrame,
    Layout,
    MechanismDiffers,
    PeerModel,
    RefusedFile,
    Translated,
    commands,
)
from plumbob.models.border import border

IMPLICIT = "the gains of its servos act at the end of a step, not at its start"
NO_GAINS = PdControllerGains(p=0.0, d=0.0)  # gains of an actuator that is no servo
FRAME = FreeJointFrame(
    lambda place, attitude: np.concatenate([attitude, place]),
    lambda pose: (pose[4:], pose[:4]),
)


def _read(path: Path, plant: Any) -> Any:
    """Reads the file `path` into a plant and completes the plant; returns the number of the file's
    model. Raises RefusedFile."""
    with border(RefusedFile):
        (model,) = Parser(plant).AddModels(str(path))
        plant.Finalize()
    return model


def model_fields(path: Path) -> Fields:
    """The numbers that Drake reads from a model file, in a plant without a time step; raises
    RefusedFile."""
    plant, graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    _read(path, plant)
    yield "gravity", "", plant.gravity_field().gravity_vector()
    for number in range(1, plant.num_bodies()):
        body = plant.get_body(BodyIndex(number))
        inertia = body.default_spatial_inertia()
        about_centre = inertia.Shift(inertia.get_com()).CalcRotationalInertia()
        moments = np.ravel(about_centre.CalcPrincipalMomentsOfInertia())
        yield "mass", body.name(), body.default_mass()
        yield "inertia", body.name(), np.sort(moments)
    for joint in map(plant.get_joint, plant.GetJointIndices()):
        if joint.num_velocities() == 1:
            yield "damping", joint.name(), joint.default_damping_vector()[0]
    for actuator in map(plant.get_joint_actuator, plant.GetJointActuatorIndices()):
        name = actuator.name()
        ratio = actuator.default_gear_ratio()
        # The gear ratio scales the inertia of the rotor, and not the force on the joint.
        yield "gear", name, 1.0
        gains = _gains(actuator)
        yield "kp", name, gains[0]
        yield "kv", name, gains[1]
        yield "armature", actuator.joint().name(), ratio**2 * actuator.default_rotor_inertia()
    yield from _frictions(graph.model_inspector())


def _frictions(inspector: Any) -> Fields:
    """The coefficients of friction of the geometries that may touch."""
    for geometry in inspector.GetAllGeometryIds():
        properties = inspector.GetProximityProperties(geometry)
        if properties is not None and properties.HasProperty("material", "coulomb_friction"):
            friction = properties.GetProperty("material", "coulomb_friction")
            name = inspector.GetName(geometry).rpartition("::")[2]
            yield "friction", name, friction.dynamic_friction()


def _gains(actuator: Any) -> tuple[float, float]:
    """The gains kp and kv of an actuator; both are 0 if the actuator is no servo."""
    gains = actuator.get_controller_gains() if actuator.has_controller() else NO_GAINS
    return gains.p, gains.d


class DrakeModel:
    """A user's model in a discrete plant, with its simulator."""

    def __init__(self, path: Path, layout: Layout, step: float) -> None:
        builder = DiagramBuilder()
        self.plant, _ = AddMultibodyPlantSceneGraph(builder, step)
        # Contact results are those of the present state, and not those of the last step.
        self.plant.SetUseSampledOutputPorts(False)
        self.file = _read(path, self.plant)
        self.step = step
        self.layout = layout
        diagram = builder.Build()
        self.simulator = simulator_of(diagram, diagram.CreateDefaultContext())
        self.context = self.plant.GetMyMutableContextFromRoot(
            self.simulator.get_mutable_context()
        )
        indices = self.plant.GetJointActuatorIndices()
        actuators = [self.plant.get_joint_actuator(index) for index in indices]
        self.commands = commands(layout, [actuator.name() for actuator in actuators])
        self.actuation = self.plant.MakeActuationMatrix()  # actuator forces -> joint forces
        self.gains = np.array([_gains(actuator) for actuator in actuators]).reshape(-1, 2).T
        self.servos = self.gains.any(axis=0)
        self.places = [actuator.joint().position_start() for actuator in actuators]

    def put(self, q: Array, v: Array) -> None:
        """Sets the coordinates `q` and their rates `v`, at the time 0, with controls and forces of
        zero."""
        self.simulator.get_mutable_context().SetTime(0.0)
        self.plant.SetPositions(self.context, q)
        self.plant.SetVelocities(self.context, v)
        self._push(np.zeros(len(self.layout.actuators)), 0.0 * v)
        self.simulator.Initialize()

    def _push(self, control: Array, force: Array) -> None:
        """Sets the controls of the actuators and a generalised `force`, both of which are held."""
        plant = self.plant
        context = self.context
        self.commanded = np.zeros(len(self.places))
        if self.commands:
            self.commanded[:] = control[self.commands]
        direct = np.where(self.servos, 0.0, self.commanded)
        plant.get_actuation_input_port().FixValue(context, direct)
        if self.servos.any():
            targets = np.concatenate([self.commanded, 0.0 * direct])
            plant.get_desired_state_input_port(self.file).FixValue(context, targets)
        plant.get_applied_generalized_force_input_port().FixValue(context, force)

    def terms(self, q: Array, v: Array, control: Array) -> dict[str, Any]:
        """The terms of the equations of motion, and the pairs of bodies that touch by Drake's
        contact results."""
        plant = self.plant
        context = self.context
        self.put(q, v)
        self._push(control, 0.0 * v)
        damping = np.zeros(plant.num_velocities())
        for joint in map(plant.get_joint, plant.GetJointIndices()):
            first = joint.velocity_start()
            damping[first : first + joint.num_velocities()] = joint.GetDampingVector(context)
        kp, kv = self.gains
        errors = self.commanded - q[self.places]
        servo_forces = kp * errors - kv * (v @ self.actuation)
        forces = np.where(self.servos, servo_forces, self.commanded)
        return {
            "mass matrix": plant.CalcMassMatrix(context),
            "gravity": plant.CalcGravityGeneralizedForces(context),
            "bias": plant.CalcBiasTerm(context),
            "passive": -damping * v,
            "actuator": self.actuation @ forces,
            "causes": {"acceleration": IMPLICIT} if self.servos.any() else {},
            "contacts": self._touching_bodies(),
        }

    def _touching_bodies(self) -> list[tuple[str, str]]:
        """The names of the pairs of bodies that touch in the present state."""
        results = self.plant.get_contact_results_output_port().Eval(self.context)
        names = list[tuple[str, str]]()
        for number in range(results.num_point_pair_contacts()):
            contact = results.point_pair_contact_info(number)
            body = self.plant.get_body(contact.bodyA_index())
            other_body = self.plant.get_body(contact.bodyB_index())
            names.append((body.name(), other_body.name()))
        return names

    def advance(self, control: Array, force: Array, steps: int) -> tuple[Array, Array]:
        """Takes `steps` steps under a control and a generalised `force`, both held; returns the
        coordinates and their rates. Raises NotRead if Drake fails."""
        self._push(control, force)
        steps_taken = round(self.simulator.get_context().get_time() / self.step + 0.5)
        with border(lambda line: MechanismDiffers(f"a step fails: {line}")):
            advance(self.simulator, steps_taken + steps, self.step)
        plant = self.plant
        return plant.GetPositions(self.context), plant.GetVelocities(self.context)


def user_model(path: Path, layout: Layout, step: float) -> PeerModel:
    """The model of a file in Drake at `step` [s], with the places of its joints in Drake's state;
    raises NotRead."""
    model = DrakeModel(path, layout, step)
    joints = []
    for joint in map(model.plant.get_joint, model.plant.GetJointIndices()):
        first, first_rate = joint.position_start(), joint.velocity_start()
        if joint.num_velocities() == 1:
            joints.append(EngineJoint(first, first_rate, joint.name()))
        elif joint.num_velocities() == FREE_VELOCITIES:
            joints.append(EngineJoint(first, first_rate, frame=FRAME))
    return Translated(model, layout, joints)
