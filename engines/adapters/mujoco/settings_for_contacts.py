"""Contact settings that give a contact a wanted restitution, depth at rest or creep, as MJCF."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mujoco

from plumbob.analytic.errors.contact_models.impacts import IMPACT_IMPEDANCE
from plumbob.analytic.errors.contact_models.soft_friction import depth_under
from plumbob.analytic.errors.contact_models.wanted_contacts import (
    LARGEST_PUSH,
    LEAST_PUSH,
    bouncing_contact,
    creep_of,
    resting_contact,
    sticking_contact,
)
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.schemes import SoftPoint
from plumbob.engines.abilities import ContactSettings, WantedContact
from plumbob.engines.adapters.mujoco.settings_to_paste import attributes_text, default_element
from plumbob.engines.adapters.mujoco.user_file import compiled_model
from plumbob.engines.method import time_step

DEFAULT_GRAVITY = 9.81  # [m/s^2] where no file says otherwise
LEAST_RUBBING = 3  # condim of a contact with friction, at least
RK4_NUMBER = int(mujoco.mjtIntegrator.mjINT_RK4)


@dataclass(frozen=True)
class ContactPlace:
    """The place of a contact: a pair of geoms of a file, or any two geoms."""

    step: float  # [s]
    gravity: float  # [m/s^2]
    push: float  # [m/s^2] acceleration that the contact's load gives the free body
    pair_fields: dict[str, object] = field(default_factory=dict)  # empty: no pair is named


def contact_settings(wanted: WantedContact) -> ContactSettings:
    """Returns the settings that give a contact a wanted property. Raises ParameterError."""
    place = _place_in_file(wanted, wanted.file) if wanted.file else _place(wanted)
    if wanted.name != "restitution" and not LEAST_PUSH <= place.push <= LARGEST_PUSH:
        allowed = f"{LEAST_PUSH:g} to {LARGEST_PUSH:g} m/s^2, not {place.push:.3g}"
        if wanted.load is None:
            raise ParameterError(
                "file", str(wanted.file), f"a model with gravity from {allowed}"
            )
        raise ParameterError("load", wanted.load, f"such that it accelerates from {allowed}")
    if wanted.name == "restitution":
        rebound = bouncing_contact(wanted.value, wanted.speed, place.step, place.gravity)
        fields: dict[str, tuple[float, ...]] = {
            "solref": rebound.impact.solref,
            "solimp": (IMPACT_IMPEDANCE, IMPACT_IMPEDANCE),
        }
        low, high, depth = rebound.low, rebound.high, rebound.depth
        options: dict[str, object] = {}
    elif wanted.name == "penetration":
        point = resting_contact(wanted.value, place.push, place.step)
        fields = _fields_of(point)
        low = high = depth = depth_under(point, place.push, place.step)
        options = {"cone": "elliptic"}  # a pyramid's depth depends on the friction
    else:
        # At the friction limit of a coefficient of 1 the pull is as large as the push.
        point = sticking_contact(wanted.value, place.push, place.push, place.step)
        fields = _fields_of(point)
        low = high = creep_of(point, place.push, place.push, place.step)
        depth = depth_under(point, place.push, place.step)
        options = {"cone": "elliptic", "impratio": point.ratio}
    return ContactSettings(
        name=wanted.name,
        value=wanted.value,
        step=place.step,
        mjcf=_mjcf(place, options, fields),
        low=low,
        high=high,
        depth=depth,
        speed=wanted.speed,
        push=place.push,
    )


def _fields_of(point: SoftPoint) -> dict[str, tuple[float, ...]]:
    """Returns the fields of a contact that behaves like `point`."""
    solref = (point.time_constant, point.damping_ratio)
    return {"solref": solref, "solimp": (*point.impedance, point.width)}


def _mjcf(place: ContactPlace, options: dict[str, object], fields: dict[str, Any]) -> str:
    """Returns the lines to paste: options, and the fields of all geoms or of one pair."""
    option = f"<option {attributes_text({'timestep': place.step, **options})}/>"
    if not place.pair_fields:
        return f"{option}\n{default_element('geom', fields)}"
    pair = attributes_text({**place.pair_fields, **fields})
    return f"{option}\n<contact>\n  <pair {pair}/>\n</contact>"


def _place(wanted: WantedContact) -> ContactPlace:
    """Returns the place of a contact of a body that stands alone."""
    if wanted.step is None:
        raise ParameterError("step", None, "given, in seconds: settings are for one step")
    push = DEFAULT_GRAVITY
    if wanted.load is not None:
        if wanted.mass is None:
            raise ParameterError("mass", None, "given with --load")
        push = wanted.load / wanted.mass
    return ContactPlace(time_step("step", wanted.step), DEFAULT_GRAVITY, push)


def _place_in_file(wanted: WantedContact, file: Path) -> ContactPlace:
    """Returns the place of a contact between two geoms of a model file. Raises ParameterError."""
    if wanted.pair is None:
        raise ParameterError("pair", None, "given with a file: the names of two geoms")
    model = compiled_model(file, "file")
    geoms = [_geom(model, file, name) for name in wanted.pair]
    if wanted.name == "restitution" and model.opt.integrator == RK4_NUMBER:
        raise ParameterError("file", str(file), "one whose integrator is not RK4")
    bodies = model.geom_bodyid[geoms]
    inverse_mass = float(model.body_invweight0[bodies, 0].sum())
    gravity = math.hypot(*model.opt.gravity)
    if not inverse_mass:
        raise ParameterError("pair", " ".join(wanted.pair), "geoms of which one can move")
    if model.body_weldid[bodies[0]] == model.body_weldid[bodies[1]]:
        raise ParameterError("pair", " ".join(wanted.pair), "geoms that can move apart")
    if wanted.mass is not None:
        raise ParameterError("mass", wanted.mass, "left out: the file has the masses")
    push = gravity if wanted.load is None else wanted.load * inverse_mass
    if not push and wanted.name != "restitution":
        raise ParameterError("load", wanted.load, "given: the file has no gravity")
    condim = int(model.geom_condim[geoms].max())
    if wanted.name == "creep" and condim < LEAST_RUBBING:
        raise ParameterError("pair", " ".join(wanted.pair), "geoms with friction, not condim 1")
    step = model.opt.timestep if wanted.step is None else wanted.step
    sliding, torsion, rolling = model.geom_friction[geoms].max(axis=0).tolist()
    pair_fields: dict[str, object] = {
        "geom1": wanted.pair[0],
        "geom2": wanted.pair[1],
        "condim": condim,
        "friction": (sliding, sliding, torsion, rolling, rolling),
    }
    return ContactPlace(time_step("step", step), gravity, push, pair_fields)


def _geom(model: Any, file: Path, name: str) -> int:
    """Returns the number of the geom with a name. Raises ParameterError."""
    number = int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, name))
    if number < 0:
        raise ParameterError("pair", name, f"the name of a geom of {file.name}")
    return number
