"""Parameters of the capsule and of its manoeuvres, as scenes and `--set` have them."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

from plumbob.analytic.parameters import ParameterError, finite, known
from plumbob.analytic.systems.capsule import Capsule, direction_to
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.models.scene import Observable, Parameters, replaced

SOURCE = (
    "F. L. Chernousko, Plane motions of a body controlled by a movable mass, "
    "Doklady RAN. Physics, Technical Sciences, 2020, vol. 494, no. 1, pp. 69-74"
)
CONTACTS = 4.0  # times a pendulum's step: three contacts to solve for, and as many forces to read
BODY = ("body_mass", "slider_mass", "inertia", "supports", "friction", "gravity")
LINE = ("w1", "w2", "t1", "support", "direction", "start")
CHECK: Parameters = MappingProxyType({
    "body_mass": 1.0, "slider_mass": 0.3, "inertia": 0.02,
    "supports": ((0.2, 0.0), (-0.1, 0.15), (-0.1, -0.15)), "friction": 0.3, "gravity": 9.81,
})  # fmt: skip
ALONG = (
    Observable("displacement", "m"),
    Observable("velocity", "m/s"),
    Observable("stroke", "m"),
    Observable("stroke_rate", "m/s"),
    Observable("heading", "rad"),
    Observable("sideways", "m"),
    Observable("normal_force_1", "N"),
    Observable("normal_force_2", "N"),
    Observable("normal_force_3", "N"),
    Observable("friction_force", "N"),
)


def capsule(parameters: Parameters) -> Capsule:
    """The capsule that parameters describe; raises ParameterError."""
    return Capsule(**{name: parameters[name] for name in BODY})


def threshold(given: Parameters) -> float:
    """f g/mu [m/s^2] of the body with some of CHECK's parameters changed."""
    return capsule({**CHECK, **given}).holding_acceleration


def along(parameters: Parameters, body: Capsule) -> float:
    """Angle [rad] of the slider's line, `direction` or that to `support`; raises ParameterError."""
    if "support" in parameters:
        return direction_to(body, parameters["support"])
    return finite("direction", parameters.get("direction", 0.0))


def manoeuvre(parameters: Parameters) -> LineManoeuvre:
    """The line manoeuvre that parameters describe; raises ParameterError."""
    body = capsule(parameters)
    return LineManoeuvre(
        body,
        parameters["w1"],
        parameters["w2"],
        parameters["t1"],
        along(parameters, body),
        parameters.get("start", 0.0),
    )


def heading(parameters: Parameters) -> float:
    """Heading of the body in the world [rad]; raises ParameterError."""
    return finite("heading", parameters.get("heading", 0.0))


def change(parameters: Parameters, changes: Parameters) -> Parameters:
    """Parameters with some values changed; of `support` and `direction` the one given counts."""
    if "support" in changes and "direction" in changes:
        raise ParameterError("direction", changes["direction"], "left out where support is given")
    for given, other in (("support", "direction"), ("direction", "support")):
        if given in changes:
            parameters = {name: value for name, value in parameters.items() if name != other}
    return replaced(parameters, changes)


def place(parameters: Parameters) -> tuple[float, float]:
    """Place of the fixed slider relative to C [m]; raises ParameterError."""
    given: Any = parameters.get("slider", (0.0, 0.0))
    try:
        x, y = given
    except (TypeError, ValueError):
        raise ParameterError("slider", given, "a point (x, y)") from None
    return finite("slider", x), finite("slider", y)


def check_names(parameters: Parameters, names: tuple[str, ...]) -> None:
    """Raise ParameterError for a name that is unknown."""
    known(parameters, names)
