"""The joints of a MuJoCo model, and what acts on them: springs, dampers, actuators, contacts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.own_model.readings import pair_name
from plumbob.engines.own_motion import Change, Element, Place

WEAKER = 0.8  # of a stiffness, or of a damping
LONGER = 2.0  # times the time constant of a contact or a limit
KINDS = mujoco.mjtConstraint
LIMITS = (int(KINDS.mjCNSTR_LIMIT_JOINT), int(KINDS.mjCNSTR_LIMIT_TENDON))


def place(model: Any, data: Any, weights: Array) -> Place:
    """The joint, or the actuator by its activation, that has most of the `weights` of positions,
    velocities and activations, in the state of `data`, whose constraints are known."""
    nv = model.nv
    places, activations = weights[:nv] + weights[nv : 2 * nv], weights[2 * nv :]
    by_joint = np.bincount(model.dof_jntid, places, model.njnt)
    if activations.size and activations.max() > by_joint.max():
        at = np.searchsorted(model.actuator_actadr, int(np.argmax(activations)), "right") - 1
        return Place(f"activation of {_name(model.actuator(at), 'actuator', int(at))}")
    joint = int(np.argmax(by_joint))
    degrees = np.flatnonzero(model.dof_jntid == joint).tolist()
    degree = max(degrees, key=lambda k: places[k])
    along = np.zeros(nv)
    along[degree] = 1.0
    inertia, unit = _inertia(model, data, along), _unit(model, joint, degree)
    heavier = tuple(
        ("dof_armature", (k,), float(model.dof_armature[k]) + _rounded(inertia)) for k in degrees
    )
    on = f" on {inertia:.2g} {unit}"
    return Place(
        _name(model.joint(joint), "joint", joint),
        (
            *_weaker(model, "stiffness", "jnt_stiffness", (joint,), on),
            *_weaker(model, "damping", "dof_damping", degrees, on),
            *_actuators(model, data, degrees, unit),
            *_tendons(model),
            *_limits(model, data, joint),
            *_contacts(model, data, int(model.jnt_bodyid[joint])),
            *_weaker(model, "density of the fluid", "density"),
            *_weaker(model, "viscosity of the fluid", "viscosity"),
        ),
        (Change(f"armature {heavier[0][2]:.2g}", heavier), *_implicit_damping(model)),
    )


def _name(thing: Any, what: str, number: int) -> str:
    return f"{what} {thing.name or number}"


def _unit(model: Any, joint: int, degree: int) -> str:
    kinds = mujoco.mjtJoint
    kind, first = model.jnt_type[joint], int(model.jnt_dofadr[joint])
    slides = kind == kinds.mjJNT_SLIDE or (kind == kinds.mjJNT_FREE and degree < first + 3)
    return "kg" if slides else "kg m²"


def _inertia(model: Any, data: Any, along: Array) -> float:
    """The inertia that a force `along` some degrees of freedom acts on, the others free."""
    moved = np.zeros((1, model.nv))
    mujoco.mj_solveM(model, data, moved, along[None, :])
    return 1.0 / float(along @ moved[0])


def _rounded(value: float) -> float:
    """A value to one digit, as one would write it."""
    return float(f"{value:.0e}")


def _weaker(
    model: Any,
    what: str,
    field: str,
    at: Sequence[int] = (),
    on: str = "",
    remedy: Change | None = None,
) -> Iterator[Element]:
    """An element with less of the numbers `at` places of a field, or of an option, where it has
    any."""
    values = np.ravel(getattr(model if at else model.opt, field))[list(at) or [0]]
    if values[0] != 0.0:
        name = f"{what} {abs(values[0]):.4g}{on}"
        places: list[tuple[int, ...]] = [(k,) for k in at] or [()]
        sets = zip([field] * len(places), places, (WEAKER * values).tolist(), strict=True)
        yield Element(name, Change(name, tuple(sets)), remedy)


def _actuators(model: Any, data: Any, degrees: Sequence[int], unit: str) -> Iterator[Element]:
    moments = _moments(model, data)
    for i in np.flatnonzero(moments[:, degrees].any(axis=1)).tolist():
        who, inertia = _name(model.actuator(i), "actuator", i), _inertia(model, data, moments[i])
        stiffness, damping = (-float(model.actuator_biasprm[i, k]) for k in (1, 2))
        first = i * model.actuator_biasprm.shape[1]
        critical = _rounded(2.0 * math.sqrt(max(stiffness, 0.0) * inertia))
        wanted = critical if critical > damping else _rounded(damping / 2.0)
        remedy = Change(f"kv {wanted:.2g}", (("actuator_biasprm", (first + 2,), -wanted),))
        for k, what in enumerate(("kp", "kv"), start=first + 1):
            on = f" on {inertia:.2g} {unit}"
            yield from _weaker(model, f"{who} {what}", "actuator_biasprm", (k,), on, remedy)


def _moments(model: Any, data: Any) -> Array:
    """Moments of the actuators, shape (actuators, degrees of freedom)."""
    moments = np.zeros((model.nu, model.nv))
    rows = (data.moment_rownnz, data.moment_rowadr, data.moment_colind)
    if model.nu:
        mujoco.mju_sparse2dense(moments, data.actuator_moment, *rows)
    return moments


def _tendons(model: Any) -> Iterator[Element]:
    for i in range(model.ntendon):
        name = _name(model.tendon(i), "tendon", i)
        for what in ("stiffness", "damping"):
            field = f"tendon_{what}"  # a number each, or the coefficients of a polynomial
            first = i * getattr(model, field).size // model.ntendon
            yield from _weaker(model, f"{name} {what}", field, (first,))


def _limits(model: Any, data: Any, joint: int) -> Iterator[Element]:
    acting = data.efc_id[np.isin(data.efc_type, LIMITS)] if data.nefc else ()
    if joint in acting:
        yield _softer(model, "its limit", (("jnt_solref", joint),))
    for i in {int(k) for k in data.efc_id[data.efc_type == int(KINDS.mjCNSTR_EQUALITY)]}:
        yield _softer(model, _name(model.equality(i), "equality", i), (("eq_solref", i),))


def _contacts(model: Any, data: Any, body: int) -> Iterator[Element]:
    """Contacts of a body, and of those that it carries."""
    carried = {body}
    for child in range(body + 1, model.nbody):
        carried |= {child} if int(model.body_parentid[child]) in carried else set()
    for geoms in {tuple(c.geom.tolist()) for c in data.contact if c.geom.min() >= 0}:
        if carried & {int(model.geom_bodyid[geom]) for geom in geoms}:
            name = f"contact {pair_name(model, geoms)}"
            yield _softer(model, name, tuple(("geom_solref", geom) for geom in geoms))


def _softer(model: Any, name: str, rows: Sequence[tuple[str, int]]) -> Element:
    """A constraint whose `solref` gets a longer time constant, or a smaller stiffness."""
    sets = list[tuple[str, tuple[int, ...], float]]()
    for field, i in rows:
        constant, damping = getattr(model, field)[i].tolist()
        if constant > 0.0:
            sets.append((field, (2 * i,), LONGER * constant))
        else:
            sets += [(field, (2 * i,), constant / LONGER**2), (field, (2 * i + 1,), damping / 2.0)]
    direct = f" {sets[-1][2]:.2g}" if constant > 0.0 else ""
    softer = Change(f"solref{direct}", tuple(sets))
    return Element(name, softer, softer)


def _implicit_damping(model: Any) -> Iterator[Change]:
    """Euler's implicit damping, where the file has it off."""
    bit = int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    if model.opt.disableflags & bit:
        yield Change("eulerdamp enabled", (("disableflags", (), -bit),))
