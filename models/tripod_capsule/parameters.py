"""The model, the parameters (by the names of `--set`) and the observables that the capsule's
systems share."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbob.analytic.parameters import ParameterError, finite, numbers
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule, PlanePoint, direction_to
from plumbob.analytic.systems.capsule_setup import CapsuleProblem, CapsuleSetup
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.three_points.reference import PlaneReference
from plumbob.analytic.theory import ErrorTheory
from plumbob.models.quantities import displacement_quantities
from plumbob.models.scene import (
    ON_SUPPORTS,
    Observable,
    Parameters,
    System,
    replaced,
)

if TYPE_CHECKING:
    from plumbob.analytic.sensitivities.neighbours import Neighbours, Sensitivity
    from plumbob.analytic.systems.three_points.motion import Event

CHERNOUSKO_2020 = (
    "F. L. Chernousko, Plane motions of a body controlled by a movable mass, "
    "Doklady RAN. Physics, Technical Sciences, 2020, vol. 494, no. 1, pp. 69-74, "
    "https://danphysras.ru"
)
MJCF = Path(__file__).parent / "tripod_capsule.xml"
STEP_COST = 4.0  # cost of a step, in steps of a pendulum: three contacts, three forces to read
CAPSULE_PARAMETERS = ("body_mass", "slider_mass", "inertia", "supports", "friction", "gravity")
LINE_PARAMETERS = ("w1", "w2", "t1", "support", "direction", "start")
CHECK: Parameters = MappingProxyType(
    {
        "body_mass": 1.0,
        "slider_mass": 0.3,
        "inertia": 0.02,
        "supports": ((0.2, 0.0), (-0.1, 0.15), (-0.1, -0.15)),
        "friction": 0.3,
        "gravity": 9.81,
    }
)
SUPPORT_LOADS = tuple(Observable(f"normal_force_{i}", "N") for i in (1, 2, 3))
OBSERVABLES_ALONG_LINE = (
    Observable("displacement", "m"),
    Observable("velocity", "m/s"),
    Observable("stroke", "m"),
    Observable("stroke_rate", "m/s"),
    Observable("heading", "rad"),
    Observable("sideways", "m"),
    *SUPPORT_LOADS,
    Observable("friction_force", "N"),
    Observable("driving_force", "N"),
)


def errors(problem: CapsuleProblem) -> ErrorTheory:
    """Returns the theory of the errors of fixed steps on a motion."""
    from plumbob.analytic.errors.sliding_motion.sliding_errors import capsule_errors

    return capsule_errors(problem)


def gradients(
    problems: Sequence[Neighbours[CapsuleProblem]], times: Array
) -> list[Sensitivity]:
    """Returns the sensitivities at `times` [s], shape (n,), by each parameter; `problems` has the
    neighbours by one parameter each."""
    from plumbob.analytic.sensitivities.capsule import capsule_gradients

    return capsule_gradients(problems, times)


def alike(problem: CapsuleProblem, near: CapsuleProblem) -> bool:
    """Returns whether a problem and its neighbour `near` have the same phases of nearly equal
    lengths."""
    from plumbob.analytic.sensitivities import capsule as sensitivities

    return sensitivities.alike(problem, near)


capsule_system = partial(
    System,
    reference=lambda problem: problem.in_world,
    observables=OBSERVABLES_ALONG_LINE,
    # Friction and the actuator do work: no energy is conserved.
    invariants=lambda problem, observed: {},
    errors=errors,
    start=("heading",),
    model_module="plumbob.models.tripod_capsule.model",
    mjcf=MJCF,
    family="capsule",
    kind=ON_SUPPORTS,
    weight=STEP_COST,
    interest=displacement_quantities,
    sensitivity=gradients,
    alike=alike,
)
"""Returns a system with the capsule's model and family; the arguments are those of `System`."""


def read_capsule(parameters: Parameters) -> Capsule:
    """Returns the capsule that parameters describe; raises ParameterError."""
    return Capsule(**{name: parameters[name] for name in CAPSULE_PARAMETERS})


UNLOADING = 0.099 / read_capsule(CHECK).mass_ratio
"""[m] distance of the slider from C, away from A1, with which A1 carries 1/300 of the weight."""


def holding_acceleration(changes: Parameters) -> float:
    """Returns f g/mu [m/s^2] of the body with some of CHECK's parameters changed."""
    return read_capsule({**CHECK, **changes}).holding_acceleration


def line_angle(parameters: Parameters, body: Capsule) -> float:
    """Returns the angle [rad] of the slider's line: `direction`, or the direction to `support`;
    raises ParameterError."""
    if "support" in parameters:
        return direction_to(body, parameters["support"])
    return finite("direction", parameters.get("direction", 0.0))


def manoeuvre(parameters: Parameters) -> LineManoeuvre:
    """Returns the line manoeuvre that parameters describe; raises ParameterError."""
    body = read_capsule(parameters)
    return LineManoeuvre(
        body,
        parameters["w1"],
        parameters["w2"],
        parameters["t1"],
        line_angle(parameters, body),
        parameters.get("start", 0.0),
    )


def line_problem(motion: Any, parameters: Parameters) -> CapsuleProblem:
    """Returns the problem of a `motion` whose slider stays on a line; raises ParameterError."""
    single = motion.single
    x, y = single.ends[0]
    body = single.capsule
    setup = CapsuleSetup(
        body,
        (x, y),
        single.direction,
        read_heading(parameters),
        press=body.gravity,
        relative_velocity=motion.relative_velocity,
    )
    return CapsuleProblem(motion, motion, setup)


def plane_problem(motion: Any, exact: Any, facing: float) -> CapsuleProblem:
    """Returns the problem of a `motion` that begins at rest and whose slider goes round C. `exact`
    gives the poses. `facing` is the body's heading [rad] in the world."""
    capsule = motion.capsule
    path = motion.path
    x, y = path.places(np.zeros(1))[0].tolist()
    setup = CapsuleSetup(
        capsule,
        (x, y),
        heading=facing,
        press=capsule.gravity,
        in_plane=True,
        plane_velocity=path.velocities,
        plane_place=path.places,
    )
    return CapsuleProblem(motion, PlaneReference(exact), setup)


def event_records(events: Iterable[Event]) -> list[dict[str, Any]]:
    """Returns the time [s], the mode and the number of the support of each event of a motion."""
    return [
        {"t": event.time, "mode": event.mode, "support": event.support + 1} for event in events
    ]


def read_heading(parameters: Parameters) -> float:
    """Returns the heading of the body in the world [rad]; raises ParameterError."""
    return finite("heading", parameters.get("heading", 0.0))


def change_line(parameters: Parameters, changes: Parameters) -> Parameters:
    """Returns parameters with some values changed. A change of `support` replaces `direction`, and
    the reverse."""
    if "support" in changes and "direction" in changes:
        direction = changes["direction"]
        raise ParameterError("direction", direction, "left out where support is given")
    for changed, replaced_name in (("support", "direction"), ("direction", "support")):
        if changed in changes:
            parameters = {n: v for n, v in parameters.items() if n != replaced_name}
    return replaced(parameters, changes)


def slider_place(parameters: Parameters) -> PlanePoint:
    """Returns the position of the fixed slider relative to C [m]; raises ParameterError."""
    value = parameters.get("slider", (0.0, 0.0))
    slider: PlanePoint = numbers("slider", value, (2,), "a point (x, y)")
    return slider
