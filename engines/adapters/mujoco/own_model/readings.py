"""Readings of a MuJoCo model's states: energy, penetration, violations."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.engines.adapters.mujoco.model_fields import control_counts, name_of
from plumbob.engines.adapters.mujoco.options import numbers_text
from plumbob.engines.adapters.mujoco.terms import put
from plumbob.engines.own_motion import HeldContacts

NAMES = ("energy", "momentum", "penetration", "slip", "limits exceeded", "equalities missed")
KINDS = mujoco.mjtConstraint
LIMITS = (KINDS.mjCNSTR_LIMIT_JOINT, KINDS.mjCNSTR_LIMIT_TENDON)
# Fraction of the friction limit: a contact with a smaller friction force is held
HELD = 0.9
# [m or rad] largest depth of contacts, and excess over limits, that a start is meant to have
DEEP = 0.01


def control_names(model: Any) -> tuple[str, ...]:
    """Returns a name for each control: the name of its actuator, with a number if the actuator has
    several controls."""
    controls = list[str]()
    for actuator, size in enumerate(control_counts(model)):
        name = name_of(model, "actuator", actuator)
        controls += (
            [f"{name}[{number}]" for number in range(size)] if size > 1 else [name] * size
        )
    return tuple(controls)


def pair_name(model: Any, pair: Any) -> str:
    """Returns the names of the two geoms of a contact."""
    return " – ".join(name_of(model, "geom", geom) for geom in pair if geom >= 0)


def readings(model: Any, data: Any, states: Array) -> Signals:
    """Returns {name: values of shape (n,)} for `states`, shape (n, ...): energy [J], momentum of a
    free model [kg m/s], deepest penetration [m], fastest slip of geoms that touch [m/s], largest
    excess of a joint or tendon over its limit, and largest violation of an equality [m or rad]. A
    reading that is 0 in all states is left out; NaN stands for a state that is not finite."""
    measured = np.full((len(NAMES), len(states)), np.nan)
    for number, state in enumerate(states):
        if np.isfinite(state).all():
            put(data, state)
            measured[:, number] = _readings_of_state(model, data)
    largest = np.nanmax(np.abs(measured), axis=1, initial=0.0)
    rows = zip(NAMES, measured, largest, strict=True)
    return {name: values for name, values, size in rows if size > 0.0}


def _readings_of_state(model: Any, data: Any) -> tuple[float, ...]:
    """Returns the readings of the state of `data`, in the order of NAMES."""
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_fwdVelocity(model, data)
    mujoco.mj_energyPos(model, data)
    mujoco.mj_energyVel(model, data)
    mujoco.mj_subtreeVel(model, data)
    # Without a free joint the momentum is 0, and is left out.
    has_free_joint = (model.jnt_type == mujoco.mjtJoint.mjJNT_FREE).any()
    mass = model.body_subtreemass[0] * has_free_joint
    depth, excess = _largest_violations(data)
    equality_distances = np.abs(_constraint_distances(data, KINDS.mjCNSTR_EQUALITY))
    return (
        data.energy.sum(),
        mass * np.linalg.norm(data.subtree_linvel[0]),
        depth,
        _fastest_slip(model, data),
        excess,
        equality_distances.max(initial=0.0),
    )


def start_warnings(start: Any) -> tuple[str, ...]:
    """Returns warnings about a `start`, an mjData whose constraints are computed: geoms deep inside
    each other, or limits far exceeded."""
    depth, excess = _largest_violations(start)
    warnings = [f"contacts {depth:.2g} m deep"] if depth > DEEP else []
    warnings += [f"limits exceeded by {excess:.2g} m or rad"] if excess > DEEP else []
    if not warnings:
        return ()
    return (f"it starts with {' and '.join(warnings)}: is that posture meant?",)


def _largest_violations(data: Any) -> tuple[float, float]:
    """Returns the deepest penetration [m], and the largest excess over a limit [m or rad]."""
    limit_distances = _constraint_distances(data, *LIMITS)
    return -data.contact.dist.min(initial=0.0), -limit_distances.min(initial=0.0)


def held_contacts(model: Any, data: Any) -> HeldContacts:
    """Returns the depth and the drift of the contacts that Coulomb friction would hold, in a state
    whose constraint forces are known in `data`."""
    depth, deepest_geoms, softness = 0.0, "", dict[str, str]()
    drift, drifting_geoms = 0.0, ""
    force = np.zeros(6)
    for number, contact in enumerate(data.contact):
        if contact.geom.min() < 0 or contact.dim == 1:
            continue  # one geom is a flex, or there is no friction
        mujoco.mj_contactForce(model, data, number, force)
        # The sum of both components is within the limit of the elliptic and the pyramidal cone.
        if not np.abs(force[1:3] / contact.friction[:2]).sum() < HELD * force[0]:
            continue
        if -contact.dist > depth:
            depth, deepest_geoms = -float(contact.dist), pair_name(model, contact.geom)
            softness = {
                "solref": numbers_text(contact.solref),
                "solimp": numbers_text(contact.solimp),
            }
        slip = contact_slip(model, data, contact)
        if slip > drift:
            drift, drifting_geoms = slip, pair_name(model, contact.geom)
    cone = ("pyramidal", "elliptic")[model.opt.cone]
    regularisation = {"impratio": f"{model.opt.impratio:g}", "cone": cone}
    return HeldContacts(
        velocity=float(np.abs(data.qvel).max(initial=0.0)),
        depth=depth,
        deepest_geoms=deepest_geoms,
        softness=softness,
        drift=drift,
        drifting_geoms=drifting_geoms,
        regularisation=regularisation,
    )


def _constraint_distances(data: Any, *kinds: Any) -> Array:
    """Returns distances [m or rad] of the constraints of some kinds, shape (n,)."""
    return np.asarray(data.efc_pos[np.isin(data.efc_type, kinds)])


def _fastest_slip(model: Any, data: Any) -> float:
    """Returns the largest speed [m/s] across the normal of two geoms that touch; 0 if none do."""
    fastest = 0.0
    for contact in data.contact:
        if contact.dist > 0.0 or contact.geom.min() < 0:
            continue  # the geoms do not touch, or one is a flex
        fastest = max(fastest, contact_slip(model, data, contact))
    return fastest


def contact_slip(model: Any, data: Any, contact: Any) -> float:
    """Returns the speed [m/s] of one geom of a contact along the other."""
    first = np.zeros((3, model.nv))
    other = np.zeros((3, model.nv))
    bodies = model.geom_bodyid[contact.geom]
    mujoco.mj_jac(model, data, first, None, contact.pos, bodies[0])
    mujoco.mj_jac(model, data, other, None, contact.pos, bodies[1])
    across = contact.frame.reshape(3, 3)[1:] @ ((other - first) @ data.qvel)
    return float(np.linalg.norm(across))
