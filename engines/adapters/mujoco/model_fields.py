"""MuJoCo's reading of bodies, joints and contacts in a model file: the reference for other
readers."""

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

JOINTS = ("armature", "damping", "stiffness", "frictionloss")
FIRST = MappingProxyType({"joint": "jntadr", "geom": "geomadr"})  # number of a body's first
CONTACTS = ("friction", "solref", "solimp")


def model_fields(path: Path) -> Fields:
    """The numbers of the model file `path`, by the names of `name_of`: gravity [m/s^2], time step
    [s], masses [kg], principal moments of inertia [kg m^2], of hinges and slides armature, damping,
    stiffness and friction loss, of geoms that may touch, and of pairs, the coefficient of friction,
    solref and solimp, and of actuators gear, kp, and kv, which a `dampratio` sets, too. Raises
    ParameterError."""
    yield from fields_in(compiled_model(path, "FILE"))


def fields_in(model: Any, named: Any = None) -> Fields:
    """Those of a compiled model; by the names of another one of the same parts."""
    parts = partial(_parts, model, named or model)
    yield "gravity", "", model.opt.gravity
    yield "timestep", "", model.opt.timestep
    for name, body in parts("body", "nbody"):
        if body.mass > 0.0:
            yield "mass", name, body.mass[0]
            yield "inertia", name, np.sort(body.inertia)
    one_degree = [int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)]
    for name, joint in parts("joint", "njnt"):
        if joint.type[0] in one_degree:
            for field in JOINTS:
                yield field, name, getattr(joint, field)[0]
    geoms = [(name, g) for name, g in parts("geom", "ngeom") if g.contype or g.conaffinity]
    for name, part in (*geoms, *parts("pair", "npair")):
        for field in CONTACTS:
            values = getattr(part, field)
            yield field, name, values[0] if field == "friction" else values
    for name, actuator in parts("actuator", "nu"):
        yield "gear", name, actuator.gear[0]
        yield "kp", name, -actuator.biasprm[1]
        yield "kv", name, -actuator.biasprm[2]


def _parts(model: Any, named: Any, kind: str, count: str) -> Iterator[tuple[str, Any]]:
    """The parts of a kind, which are as many in both models, by their names."""
    here, there = (
        actuator_count(one) if kind == "actuator" else getattr(one, count)
        for one in (model, named)
    )
    if here == there:
        for i in range(here):
            yield name_of(named, kind, i), getattr(model, kind)(i)


def actuator_count(model: Any) -> int:
    """The number of actuators; `nu` counts controls, of which an actuator may have several."""
    return len(model.actuator_trnid)


def name_of(model: Any, kind: str, number: int) -> str:
    """The name of a body, geom, joint, ...; if it has none, its place: "joint 0 of body arm",
    "body 2", "actuator 1"."""
    part = getattr(model, kind)(int(number))
    if part.name or kind not in FIRST:
        return part.name or f"{kind} {number}"
    body = model.body(int(part.bodyid[0]))
    index = int(number) - int(getattr(body, FIRST[kind])[0])
    return f"{kind} {index} of body {body.name or body.id}"


def name_with_kind(model: Any, kind: str, number: int) -> str:
    """The name of a part by `name_of`, with the kind before a name from the file: "joint hinge"."""
    name = name_of(model, kind, number)
    return f"{kind} {name}" if getattr(model, kind)(int(number)).name else name
