"""Idealisations of a system that its model file cannot state, and that an engine may need to know.

A model file imposes a motion by a huge armature, closes a loop softly, makes a bounce of a spring
and a damper, and gives a point mass a small inertia. An `Idealisations` states what is meant by
that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from plumbob.analytic.reference import Array

Velocity = Callable[[Array], Array]
"""The velocity [rad/s] or [m/s] of a joint at times [s], shape (n,) each."""


@dataclass(frozen=True)
class Idealisations:
    """Idealisations of a system, by the names in its model file."""

    velocities: Mapping[str, Velocity] = field(default_factory=dict)
    """Joints whose motion is prescribed."""
    rigid_loops: tuple[str, ...] = ()  # equality constraints that hold exactly
    restitution: Mapping[str, float] = field(default_factory=dict)
    """Shapes that bounce: the ratio of normal speeds after and before an impact."""
    points: tuple[str, ...] = ()  # bodies whose mass is in a point


NONE = Idealisations()
