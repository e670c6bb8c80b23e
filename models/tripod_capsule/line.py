"""capsule-line: one push and one brake of the slider along a line through C."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.parameters import known
from plumbob.analytic.reference import Signals
from plumbob.analytic.systems.capsule import lowest_normal_forces, source_assumption
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.manoeuvres.driving_force import force_demand
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import (
    condition_number,
    printed_body_velocity,
)
from plumbob.models.scene import Parameters, Scene, make_scene, step_sizes
from plumbob.models.tripod_capsule.parameters import (
    CAPSULE_PARAMETERS,
    CHECK,
    CHERNOUSKO_2020,
    LINE_PARAMETERS,
    capsule_system,
    change_line,
    holding_acceleration,
    line_problem,
    manoeuvre,
)

LINE_SCENE_PARAMETERS = (*CAPSULE_PARAMETERS, *LINE_PARAMETERS, "heading")
_HOLDING = holding_acceleration({})
PUSH_AND_BRAKE: Parameters = MappingProxyType(
    {
        **CHECK,
        "w1": 3 * _HOLDING,
        "w2": 0.8 * _HOLDING,
        "t1": 0.03,
        "support": 1,
    }
)


def problem(parameters: Parameters) -> CapsuleProblem:
    """Returns the problem of the line manoeuvre that parameters describe; raises ParameterError."""
    known(parameters, LINE_SCENE_PARAMETERS)
    return line_problem(manoeuvre(parameters), parameters)


def invariants(problem: CapsuleProblem, observed: Signals) -> Signals:
    """Returns by how much the friction force exceeds its largest value f (M + m) g, as a fraction.
    Without friction the common centre of mass stays at rest: returns its displacement relative to
    the body's."""
    body = problem.setup.capsule
    if body.friction == 0.0:
        displacement = observed["displacement"]
        centre_of_mass = displacement + body.mass_ratio * observed["stroke"]
        scale = float(np.abs(displacement).max()) or 1.0
        return {"centre_of_mass": centre_of_mass / scale}
    if "friction_force" not in observed:
        return {}
    friction_limit = body.friction * body.weight
    excess = np.abs(observed["friction_force"]) / friction_limit - 1.0
    return {"friction_beyond": np.maximum(excess, 0.0)}


def facts(problem: CapsuleProblem) -> Mapping[str, Any]:
    """Returns displacement, stroke and times of the manoeuvre, its demand on the actuator until t2,
    the loads, and the source's misprints."""
    line = problem.motion
    lowest, _ = lowest_normal_forces(line.capsule, line.ends)
    late = np.array([line.t_star])
    return {
        "displacement": line.displacement,
        "stroke": line.stroke,
        "t2": line.t2,
        "t_star": line.t_star,
        "t_rest": line.t_star,
        "direction": line.direction,
        **force_demand(line, line.t2).facts(),
        "holding_acceleration": line.capsule.holding_acceleration,
        "condition_number": condition_number(line),
        "lowest_normal_forces": [float(force) for force in lowest],
        "source_assumption": asdict(source_assumption(line.capsule, line.ends)),
        "findings": {
            "eq_18": "printed with an angular velocity, omega_2, where eq. 17 gives w2",
            "eq_19": "second line printed with t where eqs. 11 and 20 give t1 in its first term: "
            f"as printed the body moves at {float(printed_body_velocity(line, late)[0]):.6g} m/s "
            "when eq. 20 has it at rest",
            "eq_22": "holds along every line through C, not only C-A_i: friction has no moment "
            "about C while Q is on the line",
        },
    }


_scene = partial(
    make_scene,
    system="capsule-line",
    duration=0.15,
    steps=step_sizes(1e-3, 1e-5),
    base=PUSH_AND_BRAKE,
    source=CHERNOUSKO_2020,
    change=change_line,
)


def _mass_ratio_scene(
    case: str, slider_mass: float, summary: str, t1: float, **values: Any
) -> Scene:
    """Returns a scene with a slider of another mass; its accelerations are the same multiples of f
    g/mu."""
    holding = holding_acceleration({"slider_mass": slider_mass})
    return _scene(
        case,
        summary,
        hard="mu is nearly 0 or 1: the actuator's reaction is all or nothing",
        slider_mass=slider_mass,
        w1=3 * holding,
        w2=0.8 * holding,
        t1=t1,
        **values,
    )


def _slider_start(reach: float) -> float:
    """Returns the slider's start [m] with which the combined centre ends at `reach` [m] from C."""
    line = manoeuvre(PUSH_AND_BRAKE)
    return reach / line.capsule.mass_ratio - line.stroke


_OFF_CENTROID = ((0.2, 0.0), (-0.05, 0.15), (-0.12, -0.1))

SCENES = (
    _scene("ca1", "pushed along C–A₁, the source's Fig. 2", profile="quick"),
    _scene("ca2", "pushed along C–A₂", support=2),
    _scene("ca3", "pushed along C–A₃", support=3),
    _scene("at-50", "pushed 50° off C–A₁", direction=math.radians(50)),
    _scene("at-123", "pushed 123° off C–A₁", profile="quick", direction=math.radians(123)),
    _scene("at-222", "pushed 222° off C–A₁", direction=math.radians(222)),
    *(
        _scene(
            f"heading-{angle:03d}",
            f"pushed along C–A₁, all of it turned by {angle}°",
            heading=math.radians(angle),
            profile="quick" if angle in (0, 30) else "full",
            steps=step_sizes(1e-3, 1e-4),
        )
        for angle in range(0, 360, 15)
    ),
    _scene(
        "off-centroid",
        "a triangle whose centroid is not C, along 50 degrees",
        supports=_OFF_CENTROID,
        direction=math.radians(50),
    ),
    _scene(
        "frictionless",
        "no friction: only the reaction moves the body",
        friction=0.0,
        profile="quick",
    ),
    _scene(
        "w2-threshold",
        "a brake that uses friction up",
        w2=_HOLDING,
        hard="w2 = f g/mu: the body is held by all the friction there is",
    ),
    _scene(
        "w1-threshold",
        "a push that hardly moves the body",
        w1=_HOLDING * (1 + 1e-6),
        hard="w1 = f g/mu (1 + 1e-6): a motion of 1e-9 m, of condition 1e6",
        duration=0.07,
    ),
    _scene(
        "w1-threshold-short",
        "a push that hardly moves the body, at four step sizes",
        profile="quick",
        w1=_HOLDING * (1 + 1e-6),
        duration=0.07,
        steps=step_sizes(1e-3, 1e-4),
        hard="w1 = f g/mu (1 + 1e-6): a motion of 1e-9 m, of condition 1e6",
    ),
    _mass_ratio_scene(
        "light-slider", 1e-3, "m/M = 1e-3", 0.002, duration=0.01, steps=step_sizes(5e-5, 5e-7)
    ),
    _mass_ratio_scene("heavy-slider", 1e3, "m/M = 1e3", 0.03),
    _mass_ratio_scene(
        "lightest-slider",
        1e-6,
        "m/M = 1e-6",
        6e-5,
        duration=3e-4,
        steps=step_sizes(1.5e-6, 1.5e-8),
    ),
    _scene(
        "near-edge",
        "the combined centre ends 0.1 mm inside an edge",
        hard="N_1 -> 0",
        direction=math.pi,
        start=_slider_start(0.0999),
    ),
    _scene(
        "near-vertex",
        "the combined centre ends 0.1 mm inside a vertex",
        hard="N_2 and N_3 -> 0",
        start=_slider_start(0.1999),
    ),
    _scene(
        "off-grid",
        "t1 = 0.0317 s: on the grid of no step",
        t1=0.0317,
        hard="the control switches inside a step",
    ),
)

SYSTEM = capsule_system(
    name="capsule-line",
    rank=2,
    title="Capsule on a line",
    parameters=LINE_SCENE_PARAMETERS,
    scenes=SCENES,
    default="ca1",
    problem=problem,
    invariants=invariants,
    facts=facts,
    change=change_line,
)
