"""Drake's reading of a MuJoCo model file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from plumbob.engines.abilities import Fields


def model_fields(path: Path) -> Fields:
    """The numbers of the file `path` in a plant that is not given a step: see the adapter for
    MuJoCo. Raises RuntimeError where Drake refuses the file."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.multibody.tree import BodyIndex
    from pydrake.systems.framework import DiagramBuilder

    plant, graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    Parser(plant).AddModels(str(path))
    plant.Finalize()
    yield "gravity", "", plant.gravity_field().gravity_vector()
    for i in range(1, plant.num_bodies()):
        body = plant.get_body(BodyIndex(i))
        inertia = body.default_spatial_inertia()
        about = inertia.Shift(inertia.get_com()).CalcRotationalInertia()
        yield "mass", body.name(), body.default_mass()
        yield "inertia", body.name(), np.sort(np.ravel(about.CalcPrincipalMomentsOfInertia()))
    for joint in map(plant.get_joint, plant.GetJointIndices()):
        if joint.num_velocities() == 1:
            yield "damping", joint.name(), joint.default_damping_vector()[0]
    for actuator in map(plant.get_joint_actuator, plant.GetJointActuatorIndices()):
        ratio = actuator.default_gear_ratio()
        yield "gear", actuator.name(), ratio
        yield "armature", actuator.joint().name(), ratio**2 * actuator.default_rotor_inertia()
    inspector = graph.model_inspector()
    for geometry in inspector.GetAllGeometryIds():
        properties = inspector.GetProximityProperties(geometry)
        if properties is not None and properties.HasProperty("material", "coulomb_friction"):
            friction = properties.GetProperty("material", "coulomb_friction")
            name = inspector.GetName(geometry).rpartition("::")[2]
            yield "friction", name, friction.dynamic_friction()
