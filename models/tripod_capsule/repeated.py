"""capsule-train: repeated line manoeuvres, each with a slow return of the slider."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from plumbob.analytic.parameters import known
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.manoeuvres.driving_force import force_demand
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.manoeuvres.mean_speed import fastest_speed
from plumbob.analytic.systems.manoeuvres.repeated_line import RepeatedLine
from plumbob.models.scene import Parameters, Scene
from plumbob.models.tripod_capsule import line
from plumbob.models.tripod_capsule.parameters import (
    CHERNOUSKO_2020,
    capsule_system,
    change_line,
    line_problem,
    manoeuvre,
)

REPEATED_PARAMETERS = (*line.LINE_SCENE_PARAMETERS, "count", "fraction", "pause")
_PERIOD = 0.32  # [s] period of a manoeuvre: a whole number of steps of every size
_LINE: Parameters = MappingProxyType({**line.PUSH_AND_BRAKE, "fraction": 0.9})


def _repeated(parameters: Parameters, count: int, pause: float) -> RepeatedLine:
    """Returns `count` manoeuvres, each with a slow return and a pause [s]."""
    return RepeatedLine(manoeuvre(parameters), count, parameters["fraction"], pause)


def problem(parameters: Parameters) -> CapsuleProblem:
    """Returns the problem of the repeated manoeuvres that parameters describe; raises
    ParameterError."""
    known(parameters, REPEATED_PARAMETERS)
    manoeuvres = _repeated(parameters, parameters["count"], parameters["pause"])
    return line_problem(manoeuvres, parameters)


def facts(problem: CapsuleProblem) -> Mapping[str, Any]:
    """Returns displacement and time of all manoeuvres, and of one, with the demand of one period on
    the actuator."""
    repeated = problem.motion
    once = replace(repeated, count=1)
    return {
        "displacement": repeated.displacement,
        "t_rest": repeated.duration,
        "count": repeated.count,
        "period": repeated.period,
        "one_displacement": repeated.manoeuvre.displacement,
        "stroke": repeated.manoeuvre.stroke,
        "mean_speed": repeated.mean_speed,
        **_mean_speed_bound(once.manoeuvre),
        **force_demand(once, once.period).facts(),
    }


def _mean_speed_bound(manoeuvre: LineManoeuvre) -> dict[str, float]:
    """Returns the mean speed [m/s] that no manoeuvre of this stroke exceeds; empty without
    friction."""
    if manoeuvre.capsule.friction == 0.0:
        return {}
    return {"mean_speed_bound": fastest_speed(manoeuvre.capsule, manoeuvre.stroke)}


def _scene(case: str, count: int, profile: Any, steps: tuple[float, ...]) -> Scene:
    """Returns a scene of `count` manoeuvres."""
    pause = _PERIOD - _repeated(_LINE, 1, 0.0).period
    return Scene(
        name=f"capsule-train/{case}",
        summary=f"{count} manoeuvres, each with a slow return and a pause",
        parameters={**_LINE, "count": count, "pause": pause},
        duration=count * _PERIOD,
        steps=steps,
        source=CHERNOUSKO_2020,
        profile=profile,
    )


SCENES = (
    _scene("thousand", 1000, "full", (5e-3, 2e-3, 1e-3, 5e-4)),
    _scene("ten", 10, "quick", (5e-3, 2e-3, 1e-3, 5e-4, 2e-4)),
)

SYSTEM = capsule_system(
    name="capsule-train",
    rank=7,
    title="Capsule on repeated manoeuvres",
    parameters=REPEATED_PARAMETERS,
    scenes=SCENES,
    default="thousand",
    problem=problem,
    invariants=line.invariants,
    facts=facts,
    change=change_line,
)
