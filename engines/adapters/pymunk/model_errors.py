"""Bounds on the errors of pymunk's models, which do not come from the step."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from plumbob.analytic.errors.contact_models.sequential_impulse import opening_error
from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.engines import registry
from plumbob.engines.adapters.pymunk.methods import CLOSING_RATE, FLOOR_TIME, MOMENT
from plumbob.engines.method import Method, ModelError
from plumbob.models.largest import fastest_rate
from plumbob.models.scene import Case


def model_error(case: Case, method: Method, step: float) -> ModelError:
    """Bounds on the error of each observable, by reason; raises Unsupported."""
    family_error = FAMILIES.get(case.system.family)
    if family_error is None or "pymunk" in case.system.builders:
        return registry.model_error(case, method, step)
    return family_error(case.problem, case.scene.duration, method, step)


def rolling_ball(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Bounds from the rounding of a contact's normal. pymunk rounds the nearest point of a long
    segment to some units in the last place of the segment's length, which tilts the normal by that
    error over the ball's radius. A part of gravity then acts along the floor. Two factors 1 +
    friction bound the effect of friction."""
    far = FLOOR_TIME * problem.scale + problem.radius
    tilt = 4.0 * ULP * far / problem.radius * (1.0 + problem.friction) ** 2
    speed = tilt * problem.gravity * duration
    errors = {"x": speed * duration, "speed": speed, "spin": 2.5 * speed / problem.radius}
    return {name: {"a rounded normal": error} for name, error in errors.items()}


def simple_pendulum(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Bounds from the bob's moment of inertia, whose centre is nearer to the pivot and pulls less,
    and from the rounding of the joint's opening, which changes the tension along the rod and the
    rate across it. Empty for the linear pendulum: its body has the bob's moment of inertia about
    the axis."""
    if problem.started.linear:
        return {}
    moment = MOMENT * problem.mass * problem.length * fastest_rate(problem, duration) ** 2
    closing = 1 / step if method.settings.get("error_bias") == 0.0 else CLOSING_RATE
    rounding = opening_error(problem.mass, problem.length, closing, step)
    return {
        "theta_dot": {"rounded opening": rounding * step / (problem.mass * problem.length)},
        "tension": {"moment of the bob": moment, "rounded opening": rounding},
    }


FAMILIES: Mapping[str, Callable[[Any, float, Method, float], ModelError]] = MappingProxyType(
    {"rolling_ball": rolling_ball, "simple_pendulum": simple_pendulum}
)
