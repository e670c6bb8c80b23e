"""A scene as an equation of motion in one angle, and how the builder of a system is found."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, cast

from plumbob.engines.adapters.builders import find_builder
from plumbob.engines.method import Method
from plumbob.models.scene import System


@dataclass(frozen=True)
class Equation:
    """theta'' = acceleration(t, theta, theta_dot), its start, and the scale of its motion."""

    acceleration: Callable[[float, float, float], float]  # [s], [rad], [rad/s] -> [rad/s^2]
    theta: float  # [rad] at time 0
    theta_dot: float  # [rad/s] at time 0
    speed: float  # [rad/s] that no motion of this energy exceeds; also the scale of tolerances
    damping_rate: float = 0.0  # [1/s], already in the acceleration: -damping_rate theta_dot
    limits: Mapping[str, float] = field(default_factory=dict)
    """Magnitudes of observables that only a diverged run exceeds."""


class Builder(Protocol):
    """What the module of a family of systems, `adapters/ode/<family>.py`, offers."""

    def build(self, problem: Any, method: Method) -> Equation:
        """Write `problem` as an equation of motion; raises Unsupported."""
        ...


def builder(system: System) -> Builder:
    """The builder of `system`; raises Unsupported when there is none."""
    return cast(Builder, find_builder("ode", system))
