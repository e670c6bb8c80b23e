"""The joints of a MuJoCo model, and the parts that act on them: springs, dampers, actuators,
contacts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.model_fields import actuator_count, name_with_kind
from plumbob.engines.adapters.mujoco.own_model.readings import pair_name
from plumbob.engines.own_motion import Change, Element, Place

WEAKER = 0.8  # factor on a stiffness or a damping that is weakened
LONGER = 2.0  # factor on the time constant of a contact or a limit that is softened
KINDS = mujoco.mjtConstraint
TOUCHING = int(KINDS.mjCNSTR_CONTACT_FRICTIONLESS)  # first of the kinds of contacts
SLIDES = mujoco.mjtJoint.mjJNT_SLIDE


def place_of_weights(model: Any, data: Any, weights: Array) -> Place:
    """Returns the joint, or the actuator by its activation, with most of the `weights` of
    positions, velocities and activations, in the state of `data`, whose constraints are
    computed."""
    nv = model.nv
    by_degree = weights[:nv] + weights[nv : 2 * nv]
    activations = weights[2 * nv :]
    by_joint = np.bincount(model.dof_jntid, by_degree, model.njnt)
    if activations.size and activations.max() > by_joint.max():
        actuator = (
            np.searchsorted(model.actuator_actadr, int(np.argmax(activations)), "right") - 1
        )
        return Place(f"activation of {name_with_kind(model, 'actuator', int(actuator))}")
    joint = int(np.argmax(by_joint))
    degrees = np.flatnonzero(model.dof_jntid == joint).tolist()
    degree = max(degrees, key=lambda number: by_degree[number])
    along = np.eye(nv)[degree]
    inertia = _inertia(model, data, along)
    slides = model.jnt_type[joint] == SLIDES or (len(degrees) == 6 and degree < degrees[3])
    unit = "kg" if slides else "kg m²"
    inertia_text = f" on {inertia:.2g} {unit}"
    heavier = tuple(
        ("dof_armature", (number,), float(model.dof_armature[number]) + _rounded(inertia))
        for number in degrees
    )
    return Place(
        name_with_kind(model, "joint", joint),
        (
            *_weaker_element(model, "stiffness", "jnt_stiffness", (joint,), inertia_text),
            *_weaker_element(model, "damping", "dof_damping", degrees, inertia_text),
            *_actuators(model, data, degrees, unit),
            *_constraints(model, data, along),
        ),
        (Change(f"armature {heavier[0][2]:.2g}", heavier), *_implicit_damping(model)),
    )


def _inertia(model: Any, data: Any, along: Array) -> float:
    """Returns the inertia on which a force `along` some degrees of freedom acts, with the others
    free."""
    moved = np.zeros((1, model.nv))
    mujoco.mj_solveM(model, data, moved, along[None, :])
    return 1.0 / float(along @ moved[0])


def _rounded(value: float) -> float:
    """Returns a value rounded to one digit, as a person would write it."""
    return float(f"{value:.0e}")


def _weaker_element(
    model: Any,
    what: str,
    field: str,
    indices: Sequence[int],
    inertia_text: str,
    remedy: Change | None = None,
) -> Iterator[Element]:
    """Yields the element whose stiffness or damping is at some indices of a field, with a weaker
    version, if the first of its numbers is not 0. `what` names the number, and `inertia_text` the
    inertia on which it acts."""
    values = np.ravel(getattr(model, field))[list(indices)].tolist()
    if values[0] != 0.0:
        name = f"{what} {abs(values[0]):.4g}{inertia_text}"
        sets = tuple(
            (field, (index,), WEAKER * value)
            for index, value in zip(indices, values, strict=True)
        )
        yield Element(name, Change(name, sets), remedy)


def actuator_moments(model: Any, data: Any) -> Array:
    """Returns the moments by which actuators act on degrees of freedom, shape (actuators, nv)."""
    moments = np.zeros((actuator_count(model), model.nv))
    if moments.size:
        rows = (data.moment_rownnz, data.moment_rowadr, data.moment_colind)
        mujoco.mju_sparse2dense(moments, data.actuator_moment, *rows)
    return moments


def _actuators(model: Any, data: Any, degrees: Sequence[int], unit: str) -> Iterator[Element]:
    """Yields the stiffness and the damping of the actuators that act on some degrees of freedom."""
    moments = actuator_moments(model, data)
    for actuator in np.flatnonzero(moments[:, degrees].any(axis=1)).tolist():
        inertia = _inertia(model, data, moments[actuator])
        inertia_text = f" on {inertia:.2g} {unit}"
        # The second and the third number of an actuator's bias are -kp and -kv.
        kp_index = actuator * model.actuator_biasprm.shape[1] + 1
        kv_index = kp_index + 1
        stiffness, damping = (-model.actuator_biasprm[actuator, 1:3]).tolist()
        critical = _rounded(2.0 * math.sqrt(max(stiffness, 0.0) * inertia))
        wanted = critical if critical > damping else _rounded(damping / 2.0)
        remedy = Change(f"kv {wanted:.2g}", (("actuator_biasprm", (kv_index,), -wanted),))
        name = name_with_kind(model, "actuator", actuator)
        for gain, index in (("kp", kp_index), ("kv", kv_index)):
            yield from _weaker_element(
                model, f"{name} {gain}", "actuator_biasprm", (index,), inertia_text, remedy
            )


def _constraints(model: Any, data: Any, along: Array) -> Iterator[Element]:
    """Yields limits, equalities and contacts that act `along` a degree of freedom, each with a
    softer version."""
    column = np.zeros(data.nefc)
    mujoco.mj_mulJacVec(model, data, column, along)
    rows = np.flatnonzero(column)
    for kind, number in sorted(set(zip(data.efc_type[rows], data.efc_id[rows], strict=True))):
        if kind == KINDS.mjCNSTR_LIMIT_JOINT:
            yield _softer_element(model, "its limit", "jnt_solref", (number,))
        elif kind == KINDS.mjCNSTR_EQUALITY:
            name = name_with_kind(model, "equality", number)
            yield _softer_element(model, name, "eq_solref", (number,))
        elif kind >= TOUCHING and data.contact.geom[number].min() >= 0:
            geoms = data.contact.geom[number]
            name = f"contact {pair_name(model, geoms)}"
            yield _softer_element(model, name, "geom_solref", geoms)


def _softer_element(model: Any, name: str, field: str, rows: Sequence[int]) -> Element:
    """Returns a constraint with a softer version: a longer time constant in `solref`, or a smaller
    stiffness."""
    sets = list[tuple[str, tuple[int, ...], float]]()
    for row in map(int, rows):
        # A positive time constant and a damping ratio, or a negative stiffness and a damping
        first, second = getattr(model, field)[row].tolist()
        softer = LONGER * first, second
        if first < 0.0:
            softer = first / LONGER**2, second / LONGER
        sets += [(field, (2 * row,), softer[0]), (field, (2 * row + 1,), softer[1])]
    change = Change(f"solref {softer[0]:.2g}" if first > 0.0 else "solref", tuple(sets))
    return Element(name, change, change)


def _implicit_damping(model: Any) -> Iterator[Change]:
    """Yields the change to Euler's implicit damping, if the file has it off."""
    bit = int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    if model.opt.disableflags & bit:
        yield Change("eulerdamp enabled", (("disableflags", (), -bit),))
