"""Drake's reading of a MuJoCo model file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from plumbob.engines.abilities import ModelFields


def model_fields(path: Path) -> ModelFields:
    """The numbers of the file `path` in a plant that is not given a step: see the adapter for
    MuJoCo. Raises RuntimeError where Drake refuses the file."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.multibody.tree import BodyIndex
    from pydrake.systems.framework import DiagramBuilder

    plant, graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    Parser(plant).AddModels(str(path))
    plant.Finalize()
    gravity = plant.gravity_field().gravity_vector()
    fields: dict[tuple[str, str], tuple[float, ...]] = {("gravity", ""): tuple(gravity.tolist())}
    for i in range(1, plant.num_bodies()):
        body = plant.get_body(BodyIndex(i))
        fields["mass", body.name()] = (float(body.default_mass()),)
        fields["inertia", body.name()] = _principal_moments(body.default_spatial_inertia())
    for j in plant.GetJointIndices():
        joint = plant.get_joint(j)
        if joint.num_velocities() == 1:
            fields["damping", joint.name()] = (float(joint.default_damping_vector()[0]),)
    for a in plant.GetJointActuatorIndices():
        actuator = plant.get_joint_actuator(a)
        ratio = float(actuator.default_gear_ratio())
        fields["gear", actuator.name()] = (ratio,)
        reflected = ratio**2 * float(actuator.default_rotor_inertia())
        fields["armature", actuator.joint().name()] = (reflected,)
    return fields | _frictions(graph.model_inspector())


def _principal_moments(inertia: Any) -> tuple[float, ...]:
    """Of a spatial inertia, about the centre of mass, in order."""
    about = inertia.Shift(inertia.get_com()).CalcRotationalInertia()
    return tuple(np.sort(np.ravel(about.CalcPrincipalMomentsOfInertia())).tolist())


def _frictions(inspector: Any) -> dict[tuple[str, str], tuple[float, ...]]:
    fields: dict[tuple[str, str], tuple[float, ...]] = {}
    for geometry in inspector.GetAllGeometryIds():
        properties = inspector.GetProximityProperties(geometry)
        if properties is not None and properties.HasProperty("material", "coulomb_friction"):
            friction = properties.GetProperty("material", "coulomb_friction")
            name = inspector.GetName(geometry).rpartition("::")[2]
            fields["friction", name] = (float(friction.dynamic_friction()),)
    return fields
