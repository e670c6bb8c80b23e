"""capsule-turn: the slider goes round a circle, and the body turns the other way."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache, partial
from typing import Any

import numpy as np

from plumbob.analytic.parameters import known
from plumbob.analytic.reference import Signals
from plumbob.analytic.systems.capsule import lowest_normal_forces
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.manoeuvres.repeated_turn import RepeatedTurn
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre, turn_of
from plumbob.analytic.systems.three_points.forces import plane_demand
from plumbob.models.quantities import turn_quantities
from plumbob.models.scene import Observable, Parameters, Scene
from plumbob.models.tripod_capsule.parameters import (
    CAPSULE_PARAMETERS,
    CHECK,
    CHERNOUSKO_2020,
    SUPPORT_LOADS,
    capsule_system,
    event_records,
    plane_problem,
    read_capsule,
    read_heading,
)

TURN_PARAMETERS = ("radius", "angular_acceleration", "half_time", "start", "count", "pause")
TURN_SCENE_PARAMETERS = (*CAPSULE_PARAMETERS, *TURN_PARAMETERS, "heading")
TURN_EPSILONS = (0.3, 0.1, 0.03, 0.01, 0.003, 0.001)
TURN_DURATION = 5.0  # duration in half times: the residual motion ends by 4.2
# Numbers of steps in a half time: samples fall on 2 tau.
STEPS_IN_HALF = (50, 100, 200, 400, 800, 1600, 3200)
TURN_OBSERVABLES = (
    Observable("x", "m"),
    Observable("y", "m"),
    Observable("velocity_x", "m/s"),
    Observable("velocity_y", "m/s"),
    Observable("heading_rate", "rad/s"),
    *SUPPORT_LOADS,
)


def problem(parameters: Parameters) -> CapsuleProblem:
    """Returns the problem of the turn manoeuvre, once or repeated, that parameters describe; raises
    ParameterError."""
    known(parameters, TURN_SCENE_PARAMETERS)
    turn = TurnManoeuvre(
        read_capsule(parameters),
        parameters["radius"],
        parameters["angular_acceleration"],
        parameters["half_time"],
        parameters.get("start", 0.0),
    )
    count = parameters.get("count", 1)
    pause = parameters.get("pause", 0.0)
    turns = _repeated(turn, count, pause)
    return plane_problem(turns, turns, read_heading(parameters))


@lru_cache(maxsize=8)  # every method and step of a scene has the same motion
def _repeated(turn: TurnManoeuvre, count: int, pause: float) -> RepeatedTurn:
    """Returns `count` turns with pauses [s] between them."""
    return RepeatedTurn(turn, count, pause)


def invariants(problem: CapsuleProblem, observed: Signals) -> Signals:
    """Returns the displacement of the common centre of mass relative to the body's way: without
    friction it stays where it is. Empty with friction."""
    body = problem.setup.capsule
    if body.friction > 0.0:
        return {}
    mass_ratio = body.mass_ratio
    slider_at_start = complex(*problem.setup.slider)
    times = np.linspace(0.0, problem.motion.period, len(observed["x"]))
    slider_in_body = problem.motion.path.places(times) @ [1.0, 1j]
    arm = mass_ratio * slider_in_body * np.exp(1j * observed["body_angle"])
    place = observed["x"] + 1j * observed["y"]
    shift = place + arm - mass_ratio * slider_at_start
    return {"centre_of_mass": np.abs(shift) / (float(np.abs(arm).max()) or 1.0)}


def facts(problem: CapsuleProblem) -> Mapping[str, Any]:
    """Returns the body's angle at 2 tau and at rest, exact and by the formulas, with rates, sizes,
    loads and events."""
    turns = problem.motion
    single = turns.single
    turn = turns.manoeuvre
    stop_time = np.array([2.0 * turn.half_time])
    rest_time = np.array([single.rest_time])
    at_stop = single.at(stop_time)
    rates_by_formula = turn.rates_at_stop
    lowest_forces, _ = lowest_normal_forces(turn.capsule, turn.path.track())
    return {
        "body_angle": float(at_stop.heading[0]),
        "body_angle_at_rest": float(single.at(rest_time).heading[0]),
        "body_angle_formula": turn.body_angle,
        "body_angle_corrected": float(turn.corrected_pose[2]),
        "body_angle_corrected_at_rest": float(turn.corrected_pose_at_rest[2]),
        "stop_time": float(stop_time[0]),
        "angular_velocity_at_stop": float(at_stop.angular_velocity[0]),
        "angular_velocity_at_stop_formula": float(rates_by_formula[2]),
        "speed_at_stop": math.hypot(*at_stop.velocity[0]),
        "speed_at_stop_formula": math.hypot(*rates_by_formula[:2]),
        "rest_time": turns.duration,
        "epsilon": turn.epsilon,
        "slider_angle": turn.slider_angle,
        "inertia_ratio": turn.inertia_ratio,
        "friction_bound": turn.friction_bound,
        "drive_ratio": turn.drive_ratio,
        "count": turns.count,
        **plane_demand(single).facts(),
        "lowest_normal_forces": [float(force) for force in lowest_forces],
        "events": event_records(single.events),
    }


def _parameters(epsilon: float, body_angle: float, **values: Any) -> dict[str, Any]:
    """Returns the parameters of a turn with tau = epsilon T that turns the body by `body_angle`
    [rad] to leading order."""
    parameters: dict[str, Any] = {**CHECK, "radius": 0.12, "start": 0.0, **values}
    turn = turn_of(
        read_capsule(parameters), parameters["radius"], epsilon, body_angle, parameters["start"]
    )
    drive = {"angular_acceleration": turn.angular_acceleration, "half_time": turn.half_time}
    return parameters | drive


def _scene(
    case: str,
    summary: str,
    parameters: Parameters,
    parts: tuple[int, ...] = STEPS_IN_HALF,
    lasting: float = TURN_DURATION,
    **more: Any,
) -> Scene:
    """Returns a scene whose duration is `lasting` half times. `parts` are the numbers of steps in a
    half time."""
    half_time = parameters["half_time"]
    return Scene(
        name=f"capsule-turn/{case}",
        summary=summary,
        parameters=parameters,
        duration=lasting * half_time,
        steps=tuple(half_time / part for part in parts),
        source=CHERNOUSKO_2020,
        **more,
    )


def _epsilon_scene(epsilon: float, *, stop: bool) -> Scene:
    """Returns the scene with this epsilon. It ends when the slider stops if `stop`, and otherwise
    when the body is at rest."""
    suffix = "-stop" if stop else ""
    end = "the slider stops, at 2 tau" if stop else "all is at rest"
    hard = ""
    if epsilon < 0.03:
        hard = "centripetal forces of up to 1e5 N, and slips of micrometres"
    return _scene(
        f"{epsilon}{suffix}",
        f"epsilon {epsilon}, until {end}",
        _parameters(epsilon, -1.0),
        hard=hard,
        lasting=2.0 if stop else TURN_DURATION,
        profile="quick" if epsilon in (0.3, 0.03) and not stop else "full",
    )


def _hard_scenes(
    case: str, summary: str, parameters: Parameters, hard: str, lasting: float
) -> tuple[Scene, Scene]:
    """Returns a hard scene, and the same scene until `lasting` half times with four step sizes."""
    return (
        _scene(case, summary, parameters, hard=hard),
        _scene(
            f"{case}-short",
            f"{summary}, until {lasting:g} tau at four step sizes",
            parameters,
            hard=hard,
            lasting=lasting,
            parts=(50, 100, 200, 375),
            profile="quick",
        ),
    )


def _body_turn_of_circle(slider_mass: float) -> float:
    """Returns the body's turn [rad], to leading order, while a slider of this mass goes round a
    circle."""
    body = read_capsule({**CHECK, "slider_mass": slider_mass})
    return 2.0 * math.pi * turn_of(body, 0.12, 1.0).inertia_ratio


def _repeated_circles(count: int) -> dict[str, Any]:
    """Returns the parameters of `count` turns; in each the slider goes round one whole circle."""
    parameters = _parameters(0.1, -_body_turn_of_circle(CHECK["slider_mass"]))
    return {
        **parameters,
        "count": count,
        "pause": (TURN_DURATION - 2.0) * parameters["half_time"],
    }


SCENES = (
    *(
        _epsilon_scene(epsilon, stop=stop)
        for epsilon in TURN_EPSILONS
        for stop in (False, True)
    ),
    _scene(
        "thousand",
        "1000 turns by whole circles, the residual motion waited out after each",
        _repeated_circles(1000),
        hard="1000 turns in a row",
        lasting=1000 * TURN_DURATION,
        parts=(20, 25, 50, 100),
    ),
    *_hard_scenes(
        "pivot",
        "a gentle drive: the body pivots about A2 and slides, three times over",
        _parameters(0.8, -0.3, radius=0.2, start=5.0),
        "one support comes to rest, holds while the body pivots about it, and gives way",
        3.0,
    ),
    *_hard_scenes(
        "held",
        "a drive that friction all but holds: the body rests, and slides late",
        _parameters(3.0, -1.0),
        "friction used up by a load that grows",
        2.0,
    ),
    *_hard_scenes(
        "unloaded",
        "the common centre of mass within 0.1 % of an edge of the triangle",
        _parameters(0.1, -1.0, radius=0.999 * 0.03 / math.hypot(0.3, 0.15) / (0.3 / 1.3)),
        "one normal force goes to zero",
        2.0,
    ),
    *(
        _scene(
            f"heading-{angle:03d}",
            f"epsilon 0.3, all of it turned by {angle} degrees",
            _parameters(0.3, -1.0, heading=math.radians(angle)),
            parts=(25, 50, 100, 200),
            profile="quick" if angle == 30 else "full",
        )
        for angle in (30, 45)
    ),
    _scene(
        "light-slider",
        "m/M = 1e-3: one circle, of which friction leaves the body 0.1 mrad",
        _parameters(0.1, -_body_turn_of_circle(1e-3), slider_mass=1e-3),
        hard="mu is nearly 0: friction holds the body for most of the circle",
    ),
    _scene(
        "heavy-slider",
        "m/M = 1e3, inside the triangle",
        _parameters(0.1, -1.0, slider_mass=1e3, radius=0.08),
        hard="mu is nearly 1: the body weighs nothing beside what its supports carry",
        parts=(200, 400, 800, 1600),
    ),
)

SYSTEM = capsule_system(
    name="capsule-turn",
    rank=3,
    title="Capsule on a turn manoeuvre",
    observables=(
        Observable("body_angle", "rad"),
        *TURN_OBSERVABLES,
        Observable("heading", "rad"),
    ),
    parameters=TURN_SCENE_PARAMETERS,
    scenes=SCENES,
    default="0.1",
    problem=problem,
    invariants=invariants,
    facts=facts,
    interest=partial(turn_quantities, observable="body_angle"),
)
