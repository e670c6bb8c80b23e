"""Reads the numbers of bodies, joints, contacts and actuators of a model file with MuJoCo, as the
reference for other engines' readers."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np

from plumbob.engines.abilities import Fields
from plumbob.engines.adapters.mujoco.user_file import compiled_model

ONE_DEGREE = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
JOINTS = ("armature", "damping", "stiffness", "frictionloss")
# Field of a body that holds the number of its first joint or geom
FIRST = MappingProxyType({"joint": "jntadr", "geom": "geomadr"})
CONTACTS = ("friction", "solref", "solimp")


def model_fields(path: Path) -> Fields:
    """The numbers of a model file in SI units, by the names of `name_of`; raises ParameterError.

    - model: gravity, time step;
    - bodies: mass, principal moments of inertia;
    - hinges and slides: armature, damping, stiffness, friction loss;
    - geoms that may touch, and pairs: coefficient of friction, solref, solimp;
    - actuators: gear, kp, and kv, which a `dampratio` sets too.
    """
    yield from fields_in(compiled_model(path, "FILE"))


def fields_in(model: Any, named: Any = None) -> Fields:
    """The numbers of a compiled model, as `model_fields` has them. Names are those of the model, or
    of `named`, another model with the same parts."""
    parts = partial(_parts, model, named or model)
    yield "gravity", "", model.opt.gravity
    yield "timestep", "", model.opt.timestep
    for name, body in parts("body", "nbody"):
        if body.mass > 0.0:
            yield "mass", name, body.mass[0]
            yield "inertia", name, np.sort(body.inertia)
    for name, joint in parts("joint", "njnt"):
        if joint.type[0] in ONE_DEGREE:
            for field in JOINTS:
                yield field, name, getattr(joint, field)[0]
    geoms = [
        (name, geom)
        for name, geom in parts("geom", "ngeom")
        if geom.contype or geom.conaffinity
    ]
    for name, part in (*geoms, *parts("pair", "npair")):
        for field in CONTACTS:
            values = getattr(part, field)
            yield field, name, values[0] if field == "friction" else values
    for name, actuator in parts("actuator", "nu"):
        yield "gear", name, actuator.gear[0]
        yield "kp", name, -actuator.biasprm[1]
        yield "kv", name, -actuator.biasprm[2]


def _parts(model: Any, named: Any, kind: str, count: str) -> Iterator[tuple[str, Any]]:
    """Yields the parts of a kind with their names; none if the two models differ in their
    number."""
    counts = [
        actuator_count(counted) if kind == "actuator" else getattr(counted, count)
        for counted in (model, named)
    ]
    if counts[0] == counts[1]:
        for number in range(counts[0]):
            yield name_of(named, kind, number), getattr(model, kind)(number)


def actuator_count(model: Any) -> int:
    """The number of actuators. MuJoCo's `nu` counts controls, of which an actuator may have
    several."""
    return len(model.actuator_trnid)


def control_counts(model: Any) -> Any:
    """The number of controls of each actuator: one in releases before 3.11, which have no field for
    it."""
    return getattr(model, "actuator_ctrlnum", np.ones(actuator_count(model), int))


def name_of(model: Any, kind: str, number: int) -> str:
    """The name of a body, geom, joint, ...; if the file gives it none, its place in the file:
    "joint 0 of body arm", "body 2", "actuator 1"."""
    part = getattr(model, kind)(int(number))
    if part.name or kind not in FIRST:
        return part.name or f"{kind} {number}"
    body = model.body(int(part.bodyid[0]))
    index = int(number) - int(getattr(body, FIRST[kind])[0])
    return f"{kind} {index} of body {body.name or body.id}"


def name_with_kind(model: Any, kind: str, number: int) -> str:
    """The name of a part by `name_of`, after its kind if the name is from the file: "joint
    hinge"."""
    name = name_of(model, kind, number)
    return f"{kind} {name}" if getattr(model, kind)(int(number)).name else name
