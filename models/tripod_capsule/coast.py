"""capsule-coast: the slider is fixed, and the body coasts to rest."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.parameters import finite, known
from plumbob.analytic.reference import Signals
from plumbob.analytic.systems.capsule_setup import CapsuleProblem, CapsuleSetup
from plumbob.analytic.systems.manoeuvres.residual_motion import coasting
from plumbob.analytic.systems.slider_path import fixed
from plumbob.analytic.systems.three_points.friction import InitialVelocities, three_point_motion
from plumbob.analytic.systems.three_points.reference import PlaneReference
from plumbob.models.quantities import pose_quantities
from plumbob.models.scene import Observable, Parameters, make_scene, step_sizes
from plumbob.models.tripod_capsule.parameters import (
    CAPSULE_PARAMETERS,
    CHECK,
    CHERNOUSKO_2020,
    SUPPORT_LOADS,
    UNLOADING,
    capsule_system,
    event_records,
    read_capsule,
    read_heading,
    slider_place,
)

COAST_PARAMETERS = (
    *CAPSULE_PARAMETERS,
    "slider",
    "velocity_x",
    "velocity_y",
    "heading_rate",
    "heading",
)
_CHECK: Parameters = MappingProxyType(
    {
        **CHECK,
        "slider": (0.12, 0.0),
        "velocity_x": 0.0,
        "velocity_y": 0.0,
        "heading_rate": 0.0,
    }
)
_ARM = 0.18
_ROUND = tuple((_ARM * math.cos(a), _ARM * math.sin(a)) for a in (0.3, 2.2, 4.6))


def problem(parameters: Parameters) -> CapsuleProblem:
    """Returns the problem of the residual motion that parameters describe, by its formula if it has
    one; raises ParameterError."""
    known(parameters, COAST_PARAMETERS)
    body = read_capsule(parameters)
    slider = slider_place(parameters)
    heading_at_start = read_heading(parameters)
    vx, vy = (finite(name, parameters[name]) for name in ("velocity_x", "velocity_y"))
    rate = finite("heading_rate", parameters["heading_rate"])
    setup = CapsuleSetup(
        body,
        slider,
        direction=math.atan2(vy, vx),
        heading=heading_at_start,
        velocity=(vx, vy),
        heading_rate=rate,
        press=body.gravity,
        in_plane=True,
    )
    closed_form = coasting(body, slider, (vx, vy), rate)
    if closed_form is not None:
        return CapsuleProblem(closed_form, closed_form, setup)
    motion = three_point_motion(body, fixed(slider), InitialVelocities((vx, vy), rate))
    return CapsuleProblem(motion, PlaneReference(motion), setup)


def invariants(problem: CapsuleProblem, observed: Signals) -> Signals:
    """Returns the rise of the kinetic energy from one sample to the next, relative to the energy at
    the start."""
    body = problem.setup.capsule
    # A model without a turn has a heading of zero.
    zero = np.zeros_like(observed["velocity_x"])
    rate = observed.get("heading_rate", zero)
    turn = observed.get("heading", zero)
    velocity = observed["velocity_x"] + 1j * observed["velocity_y"]
    slider_place = complex(*problem.setup.slider)
    slider_velocity = velocity + 1j * rate * np.exp(1j * turn) * slider_place
    body_term = body.body_mass * np.abs(velocity) ** 2
    slider_term = body.slider_mass * np.abs(slider_velocity) ** 2
    twice_energy = body_term + slider_term + body.inertia * rate**2
    return {"energy_gained": np.maximum(np.diff(twice_energy), 0.0) / twice_energy[0]}


def facts(problem: CapsuleProblem) -> Mapping[str, Any]:
    """Returns how far and how long the body coasts."""
    motion = problem.motion
    end = problem.in_world.observe(np.array([motion.sliding_time]))
    rest_pose = {name: float(end[name][0]) for name in ("x", "y", "heading")}
    facts: dict[str, Any] = {"t_rest": motion.sliding_time, "rest": rest_pose}
    if motion.kind == "plane":
        facts["events"] = event_records(motion.events)
    else:
        facts |= {"distance": motion.distance, "deceleration": motion.deceleration}
    return facts


_scene = partial(
    make_scene,
    system="capsule-coast",
    steps=step_sizes(1e-3, 1e-5),
    base=_CHECK,
    source=CHERNOUSKO_2020,
)


SCENES = (
    _scene(
        "translation",
        "without spin, Q off C: over v^2/(2 f g), wherever Q is",
        0.2,
        "quick",
        velocity_x=0.4,
        velocity_y=0.2,
    ),
    _scene(
        "rotation",
        "a turn about C with supports equally far from it, Q at C",
        0.2,
        "quick",
        supports=_ROUND,
        slider=(0.0, 0.0),
        heading_rate=6.0,
    ),
    _scene(
        "spin",
        "spin and translation at once, coupled by friction: no formula",
        0.35,
        "quick",
        velocity_x=0.4,
        velocity_y=0.2,
        heading_rate=6.0,
    ),
    _scene(
        "edge",
        "without spin, the combined centre 1 mm inside an edge",
        0.2,
        "full",
        hard="N_1 -> 0",
        steps=step_sizes(2e-4, 1e-5),
        slider=(-UNLOADING, 0.0),
        velocity_x=0.4,
        velocity_y=0.2,
    ),
)

SYSTEM = capsule_system(
    name="capsule-coast",
    rank=6,
    title="Capsule coasting to rest",
    observables=(
        Observable("x", "m"),
        Observable("y", "m"),
        Observable("velocity_x", "m/s"),
        Observable("velocity_y", "m/s"),
        Observable("heading", "rad"),
        Observable("heading_rate", "rad/s"),
        *SUPPORT_LOADS,
    ),
    parameters=COAST_PARAMETERS,
    scenes=SCENES,
    default="translation",
    problem=problem,
    invariants=invariants,
    facts=facts,
    interest=pose_quantities,
    start=("velocity_x", "velocity_y", "heading_rate", "heading"),
)
