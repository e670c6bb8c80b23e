"""Line manoeuvres in a row, the slider brought back slowly after each: capsule-train."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from types import MappingProxyType
from typing import Any

from plumbob.analytic.errors.sliding_errors import repeated_line_errors
from plumbob.analytic.errors.theory import StepErrors
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_setup import CapsuleProblem, CapsuleSetup
from plumbob.analytic.systems.manoeuvres.repeated_line import RepeatedLine
from plumbob.models.scene import Parameters, Scene, System
from plumbob.models.tripod_capsule import line
from plumbob.models.tripod_capsule.parameters import (
    ALONG,
    CHECK,
    CONTACTS,
    SOURCE,
    change,
    check_names,
    heading,
    manoeuvre,
    threshold,
)

NAMES = (*line.NAMES, "count", "fraction", "pause")
_PERIOD = 0.32  # [s], a whole number of every step of the step_sizes
_LINE: Parameters = MappingProxyType({
    **CHECK, "w1": 3 * threshold({}), "w2": 0.8 * threshold({}), "t1": 0.03, "support": 1,
    "fraction": 0.9,
})  # fmt: skip


def _train(parameters: Parameters, count: int, pause: float) -> RepeatedLine:
    return RepeatedLine(manoeuvre(parameters), count, parameters["fraction"], pause)


def problem(parameters: Parameters) -> CapsuleProblem:
    """The train of manoeuvres that parameters describe; raises ParameterError."""
    check_names(parameters, NAMES)
    train = _train(parameters, parameters["count"], parameters["pause"])
    one = train.manoeuvre
    return CapsuleProblem(
        train,
        train,
        CapsuleSetup(
            one.capsule,
            one.segment.start,
            one.direction,
            heading(parameters),
            press=one.capsule.gravity,
            relative_velocity=train.relative_velocity,
        ),
    )


def invariants(problem: CapsuleProblem, observed: Mapping[str, Array]) -> Mapping[str, Array]:
    """As for a single manoeuvre."""
    return line.invariants(problem, observed)


def facts(problem: CapsuleProblem) -> Mapping[str, Any]:
    """Displacement and time of the whole train, and of one manoeuvre."""
    train = problem.motion
    return {
        "displacement": train.displacement,
        "t_rest": train.duration,
        "count": train.count,
        "period": train.period,
        "one_displacement": train.manoeuvre.displacement,
        "stroke": train.manoeuvre.stroke,
    }


def _scene(case: str, count: int, profile: Any, steps: tuple[float, ...]) -> Scene:
    pause = _PERIOD - _train(_LINE, 1, 0.0).period
    return Scene(
        f"capsule-train/{case}", f"{count} manoeuvres, each with a slow return and a pause",
        {**_LINE, "count": count, "pause": pause}, count * _PERIOD, steps, SOURCE, profile,
    )  # fmt: skip


SCENES = (
    _scene("thousand", 1000, "full", (5e-3, 2e-3, 1e-3, 5e-4)),
    _scene("ten", 10, "quick", (5e-3, 2e-3, 1e-3, 5e-4, 2e-4)),
)

SYSTEM = System(
    name="capsule-train",
    title="Capsule on a train of manoeuvres",
    observables=ALONG,
    parameters=NAMES,
    scenes=SCENES,
    default="thousand",
    problem=problem,
    reference=lambda problem: problem.reference,
    errors=lambda problem: StepErrors(partial(repeated_line_errors, problem.motion)),
    invariants=invariants,
    facts=facts,
    mjcf=line.MJCF,
    family="capsule",
    change=change,
    weight=CONTACTS,
)
