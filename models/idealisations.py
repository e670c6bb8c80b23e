"""Idealisations of a system that its model file cannot state, and that an engine may need to know.

A model file imposes a motion by a huge armature, closes a loop softly, makes a bounce of a spring
and a damper, and gives a point mass a small inertia. An `Idealisations` states the ideal that each
of them stands for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from plumbob.analytic.reference import Array

Velocity = Callable[[Array], Array]
"""Returns the velocity [rad/s] or [m/s] of a joint at times [s], shape (n,) each."""


@dataclass(frozen=True)
class Idealisations:
    """Idealisations of a system, by the names in its model file."""

    velocities: Mapping[str, Velocity] = field(default_factory=dict)
    """{joint: its prescribed velocity}."""
    rigid_loops: tuple[str, ...] = ()  # names of equality constraints that hold exactly
    restitution: Mapping[str, float] = field(default_factory=dict)
    """{shape that bounces: ratio of its normal speeds after and before an impact}."""
    points: tuple[str, ...] = ()  # names of bodies whose mass is in a point


NONE = Idealisations()
