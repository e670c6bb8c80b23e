"""A system of one's own: a body that falls from rest with linear drag, v' = g - c v."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plumbob.analytic.parameters import known, positive
from plumbob.models.scene import Observable, Scene, System, step_sizes

ULP = float(np.finfo(np.float64).eps)
NAMES = ("gravity", "drag_rate")


@dataclass(frozen=True)
class FallingBody:
    """A body under `gravity` [m/s^2] with drag `drag_rate` [1/s] times its speed; raises
    ParameterError."""

    gravity: float
    drag_rate: float

    def __post_init__(self):
        positive("gravity", self.gravity)
        positive("drag_rate", self.drag_rate)

    def observe(self, times):
        """Depth [m] and speed [m/s] at `times` [s], shape (n,)."""
        last = self.gravity / self.drag_rate
        speed = -last * np.expm1(-self.drag_rate * times)
        return {"depth": last * times - speed / self.drag_rate, "speed": speed}

    def uncertainty(self, times):
        """Absolute errors, shape (n,), of rounded parameters and terms."""
        speed = 4.0 * ULP * self.gravity / self.drag_rate * np.ones_like(times)
        return {"depth": speed * (times + 1.0 / self.drag_rate), "speed": speed}

    def nonlinearity(self, times, errors):
        """Zero: the equation is linear."""
        return 0.0


def problem(parameters):
    """The body that parameters describe; raises ParameterError."""
    known(parameters, NAMES)
    return FallingBody(**parameters)


SYSTEM = System(
    name="falling-body",
    title="Falling body with drag",
    observables=(Observable("depth", "m"), Observable("speed", "m/s")),
    parameters=NAMES,
    scenes=(
        Scene(
            name="falling-body/from-rest",
            summary="from rest to 92 % of the terminal speed",
            parameters={"gravity": 9.81, "drag_rate": 0.5},
            duration=5.0,
            steps=step_sizes(1.0, 1e-3),
            source="any textbook of mechanics",
            profile="quick",
        ),
    ),
    default="from-rest",
    problem=problem,
    reference=lambda body: body,
    invariants=lambda body, observed: {},  # drag does work
    facts=lambda body: {"terminal_speed": body.gravity / body.drag_rate},
    mjcf=Path(__file__).with_suffix(
        ".xml"
    ),  # there is none: no engine that reads MJCF builds it
    family="falling_body",
    builders={"ode": "falling_body_ode"},  # the module that has its equation
)
