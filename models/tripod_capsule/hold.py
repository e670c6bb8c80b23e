"""capsule-hold: a body held by friction, under tilted gravity or with a slowly moving slider."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from plumbob.analytic.parameters import finite, known
from plumbob.analytic.systems.capsule_setup import CapsuleProblem, CapsuleSetup
from plumbob.analytic.systems.manoeuvres.driving_force import force_demand
from plumbob.analytic.systems.manoeuvres.slow_motion import SlowStroke
from plumbob.analytic.systems.manoeuvres.tilted_hold import TiltedHold, tilt_angle
from plumbob.models.scene import Parameters, Scene, step_sizes
from plumbob.models.tripod_capsule.parameters import (
    CAPSULE_PARAMETERS,
    CHECK,
    CHERNOUSKO_2020,
    UNLOADING,
    capsule_system,
    change_line,
    line_angle,
    line_problem,
    read_capsule,
    read_heading,
    slider_place,
)

HOLD_PARAMETERS = (
    *CAPSULE_PARAMETERS,
    "fraction",
    "direction",
    "support",
    "slider",
    "length",
    "start",
    "heading",
)
_TILTED: Parameters = MappingProxyType({**CHECK, "direction": 0.7, "slider": (0.05, 0.03)})


def problem(parameters: Parameters) -> CapsuleProblem:
    """Returns the problem of a body under tilted gravity, or, if a `length` is given, of a slow
    stroke; raises ParameterError."""
    known(parameters, HOLD_PARAMETERS)
    if "length" in parameters:
        return _stroke_problem(parameters)
    body = read_capsule(parameters)
    heading_at_start = read_heading(parameters)
    slider = slider_place(parameters)
    line = line_angle(parameters, body)
    hold = TiltedHold(body, finite("fraction", parameters["fraction"]), line, slider)
    tilt = tilt_angle(body, hold.fraction)
    pull = body.gravity * math.sin(tilt)
    press = body.gravity * math.cos(tilt)
    setup = CapsuleSetup(body, slider, line, heading_at_start, pull=pull, press=press)
    return CapsuleProblem(hold, hold, setup)


def _stroke_problem(parameters: Parameters) -> CapsuleProblem:
    """Returns the problem of a slow stroke of the slider, out and back; raises ParameterError."""
    body = read_capsule(parameters)
    line = line_angle(parameters, body)
    start = parameters.get("start", 0.0)
    stroke = SlowStroke(body, parameters["length"], parameters["fraction"], line, start)
    return line_problem(stroke, parameters)


def facts(problem: CapsuleProblem) -> Mapping[str, Any]:
    """Returns the used fraction of the friction limit: under tilted gravity with the tilt and the
    force, for a stroke with its length, its duration and its demand on the actuator."""
    body = problem.setup.capsule
    hold = problem.motion
    facts: dict[str, Any] = {
        "displacement": 0.0,
        "fraction": hold.fraction,
        "holding_acceleration": body.holding_acceleration,
    }
    if hold.kind == "stroke":
        actuator_demand = force_demand(hold, hold.duration).facts()
        return {**facts, "stroke": hold.length, "t_rest": hold.duration, **actuator_demand}
    tilt = tilt_angle(body, hold.fraction)
    return {
        **facts,
        "tilt_angle": tilt,
        "force": body.weight * math.sin(tilt),
        "note": "fraction of the largest tilt: tan(angle) = fraction f, wherever Q is fixed",
    }


def _tilted_scene(fraction: float) -> Scene:
    """Returns the scene at a fraction of the largest tilt that friction holds."""
    hard = ""
    if fraction >= 0.999:
        hard = f"friction used up but for {1 - fraction:.0e} of it"
    return Scene(
        name=f"capsule-hold/{fraction}",
        summary=f"10 s at {fraction} of the tilt that friction holds",
        parameters={**_TILTED, "fraction": fraction},
        duration=10.0,
        steps=step_sizes(5e-3, 1e-4),
        source=CHERNOUSKO_2020,
        profile="quick" if fraction == 0.999 else "full",
        hard=hard,
    )


SCENES = (
    *(_tilted_scene(fraction) for fraction in (0.5, 0.9, 0.99, 0.999, 0.999999)),
    Scene(
        name="capsule-hold/slow-motion",
        summary="the slider out and back at 0.999 of f g/mu",
        parameters={**CHECK, "direction": 0.7, "length": 0.08, "fraction": 0.999},
        duration=0.4,
        steps=step_sizes(1e-3, 1e-5),
        source=CHERNOUSKO_2020,
    ),
    Scene(
        name="capsule-hold/unloading",
        summary="out until A1 carries 1/300 of the weight, and back",
        parameters={**CHECK, "direction": math.pi, "length": UNLOADING, "fraction": 0.999},
        duration=0.8,
        steps=step_sizes(1e-3, 1e-5),
        source=CHERNOUSKO_2020,
        hard="N_1 -> 0",
    ),
)

SYSTEM = capsule_system(
    name="capsule-hold",
    rank=5,
    title="Capsule held by friction",
    parameters=HOLD_PARAMETERS,
    scenes=SCENES,
    default="0.999",
    problem=problem,
    facts=facts,
    change=change_line,
)
