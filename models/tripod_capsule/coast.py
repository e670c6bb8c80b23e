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
from plumbob.analytic.systems.three_points.friction import Start, three_point_motion
from plumbob.analytic.systems.three_points.reference import PlaneReference
from plumbob.models.quantities import pose
from plumbob.models.scene import Observable, Parameters, scene_of, step_sizes
from plumbob.models.tripod_capsule.parameters import (
    BODY,
    CHECK,
    LOADS,
    SOURCE,
    UNLOADING,
    capsule,
    capsule_system,
    heading,
    place,
)

NAMES = (*BODY, "slider", "velocity_x", "velocity_y", "heading_rate", "heading")
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
    """Returns the residual motion that parameters describe, by its formula if it has one; raises
    ParameterError."""
    known(parameters, NAMES)
    body = capsule(parameters)
    slider = place(parameters)
    turned = heading(parameters)
    vx, vy = (finite(name, parameters[name]) for name in ("velocity_x", "velocity_y"))
    rate = finite("heading_rate", parameters["heading_rate"])
    line = math.atan2(vy, vx)
    setup = CapsuleSetup(
        body, slider, line, turned, (vx, vy), rate, press=body.gravity, in_plane=True
    )
    closed = coasting(body, slider, (vx, vy), rate)
    if closed is not None:
        return CapsuleProblem(closed, closed, setup)
    motion = three_point_motion(body, fixed(slider), Start((vx, vy), rate))
    return CapsuleProblem(motion, PlaneReference(motion), setup)


def invariants(problem: CapsuleProblem, observed: Signals) -> Signals:
    """Returns the rise of the kinetic energy from one sample to the next, relative to the energy at
    the start."""
    body = problem.setup.capsule
    still = np.zeros_like(observed["velocity_x"])
    # A model without a turn has a heading of zero.
    rate, turn = (observed.get(name, still) for name in ("heading_rate", "heading"))
    velocity = observed["velocity_x"] + 1j * observed["velocity_y"]
    slider = velocity + 1j * rate * np.exp(1j * turn) * complex(*problem.setup.slider)
    squares = body.body_mass * np.abs(velocity) ** 2 + body.slider_mass * np.abs(slider) ** 2
    energy = squares + body.inertia * rate**2
    return {"energy_gained": np.maximum(np.diff(energy), 0.0) / energy[0]}


def facts(problem: CapsuleProblem) -> Mapping[str, Any]:
    """Returns how far and how long the body coasts."""
    motion = problem.motion
    about = dict[str, Any]()
    if motion.kind == "plane":
        about["events"] = [
            {"t": e.time, "mode": e.mode, "support": e.support + 1} for e in motion.events
        ]
    else:
        about |= {"distance": motion.distance, "deceleration": motion.deceleration}
    end = problem.in_world.observe(np.array([motion.sliding_time]))
    pose = {name: float(end[name][0]) for name in ("x", "y", "heading")}
    return {"t_rest": motion.sliding_time, "rest": pose, **about}


_scene = partial(
    scene_of,
    system="capsule-coast",
    steps=step_sizes(1e-3, 1e-5),
    base=_CHECK,
    source=SOURCE,
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
    title="Capsule coasting to rest",
    observables=(
        Observable("x", "m"),
        Observable("y", "m"),
        Observable("velocity_x", "m/s"),
        Observable("velocity_y", "m/s"),
        Observable("heading", "rad"),
        Observable("heading_rate", "rad/s"),
        *LOADS,
    ),
    parameters=NAMES,
    scenes=SCENES,
    default="translation",
    problem=problem,
    invariants=invariants,
    facts=facts,
    interest=pose,
    start=("velocity_x", "velocity_y", "heading_rate", "heading"),
)
