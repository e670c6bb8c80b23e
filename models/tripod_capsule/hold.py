"""capsule-hold: a body held by friction, under tilted gravity or with a slowly moving slider."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from plumbob.analytic.parameters import finite, known
from plumbob.analytic.systems.capsule_setup import CapsuleProblem, CapsuleSetup
from plumbob.analytic.systems.manoeuvres.driving_force import demand
from plumbob.analytic.systems.manoeuvres.slow_motion import SlowStroke
from plumbob.analytic.systems.manoeuvres.tilted_hold import TiltedHold, tilt_angle
from plumbob.models.scene import Parameters, Scene, step_sizes
from plumbob.models.tripod_capsule.parameters import (
    BODY,
    CHECK,
    SOURCE,
    UNLOADING,
    along,
    capsule,
    capsule_system,
    change_line,
    heading,
    on_line,
    place,
)

NAMES = (*BODY, "fraction", "direction", "support", "slider", "length", "start", "heading")
_TILTED: Parameters = MappingProxyType({**CHECK, "direction": 0.7, "slider": (0.05, 0.03)})


def problem(parameters: Parameters) -> CapsuleProblem:
    """Returns the body under tilted gravity, or, if a `length` is given, with a slow stroke; raises
    ParameterError."""
    known(parameters, NAMES)
    if "length" in parameters:
        return _stroke(parameters)
    body = capsule(parameters)
    turned = heading(parameters)
    slider = place(parameters)
    line = along(parameters, body)
    hold = TiltedHold(body, finite("fraction", parameters["fraction"]), line, slider)
    angle = tilt_angle(body, hold.fraction)
    pull = body.gravity * math.sin(angle)
    press = body.gravity * math.cos(angle)
    return CapsuleProblem(
        hold, hold, CapsuleSetup(body, slider, line, turned, pull=pull, press=press)
    )


def _stroke(parameters: Parameters) -> CapsuleProblem:
    """Returns the body with a slow stroke of its slider; raises ParameterError."""
    body = capsule(parameters)
    length = parameters["length"]
    fraction = parameters["fraction"]
    start = parameters.get("start", 0.0)
    return on_line(
        SlowStroke(body, length, fraction, along(parameters, body), start), parameters
    )


def facts(problem: CapsuleProblem) -> Mapping[str, Any]:
    """Returns the load on friction, and the friction limit."""
    body = problem.setup.capsule
    hold = problem.motion
    about: dict[str, Any] = {
        "displacement": 0.0,
        "fraction": hold.fraction,
        "holding_acceleration": body.holding_acceleration,
    }
    if hold.kind == "stroke":
        return {**about, "stroke": hold.length, "t_rest": hold.duration} | demand(
            hold, hold.duration
        ).facts()
    return {
        **about,
        "tilt_angle": tilt_angle(body, hold.fraction),
        "force": body.weight * math.sin(tilt_angle(body, hold.fraction)),
        "note": "fraction of the largest tilt: tan(angle) = fraction f, wherever Q is fixed",
    }


SCENES = (
    *(
        Scene(
            f"capsule-hold/{fraction}",
            f"10 s at {fraction} of the tilt that friction holds",
            {**_TILTED, "fraction": fraction},
            10.0,
            step_sizes(5e-3, 1e-4),
            SOURCE,
            profile="quick" if fraction == 0.999 else "full",
            hard=f"friction used up but for {1 - fraction:.0e} of it"
            if fraction >= 0.999
            else "",
        )
        for fraction in (0.5, 0.9, 0.99, 0.999, 0.999999)
    ),
    Scene(
        "capsule-hold/slow-motion",
        "the slider out and back at 0.999 of f g/mu",
        {**CHECK, "direction": 0.7, "length": 0.08, "fraction": 0.999},
        0.4,
        step_sizes(1e-3, 1e-5),
        SOURCE,
    ),
    Scene(
        "capsule-hold/unloading",
        "out until A1 carries 1/300 of the weight, and back",
        {**CHECK, "direction": math.pi, "length": UNLOADING, "fraction": 0.999},
        0.8,
        step_sizes(1e-3, 1e-5),
        SOURCE,
        hard="N_1 -> 0",
    ),
)

SYSTEM = capsule_system(
    name="capsule-hold",
    title="Capsule held by friction",
    parameters=NAMES,
    scenes=SCENES,
    default="0.999",
    problem=problem,
    facts=facts,
    change=change_line,
)
