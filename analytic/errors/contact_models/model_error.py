"""Bounds on what an engine's model adds to a motion of the capsule, apart from the step: their
types, and the sizes that every mechanism needs."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from plumbob.analytic.systems.capsule import Capsule

Bounds = Mapping[str, float]
"""{observable: absolute bound}, SI units."""
ModelError = Mapping[str, Mapping[str, float]]
"""{observable: {reason: absolute bound}}, SI units."""


def by_observable(parts: Mapping[str, Bounds]) -> ModelError:
    """{reason: {observable: bound}} as {observable: {reason: bound}}.

    >>> by_observable({"rounding": {"x": 1e-15, "y": 2e-15}, "depth": {"x": 1e-9}})
    {'x': {'rounding': 1e-15, 'depth': 1e-09}, 'y': {'rounding': 2e-15}}
    """
    names = dict.fromkeys(name for bounds in parts.values() for name in bounds)
    return {
        name: {why: bounds[name] for why, bounds in parts.items() if name in bounds}
        for name in names
    }


def with_drive(bounds: Bounds, capsule: Capsule, step: float) -> Bounds:
    """Bounds on a motion along a line in steps of `step` [s], with that on the actuator's force
    that follows unless it is there: mu of that on friction, and (1 - mu) m of that on the slider's
    mean acceleration over a step, at both of whose ends its velocity may be wrong."""
    if "driving_force" in bounds:
        return bounds
    slid, mu = 2.0 * bounds.get("stroke_rate", 0.0) / step, capsule.mass_ratio
    force = mu * bounds.get("friction_force", 0.0) + (1.0 - mu) * capsule.slider_mass * slid
    return {**bounds, "driving_force": force} if force else bounds


def support_arm(capsule: Capsule) -> float:
    """Root mean square distance of the supports from C [m]."""
    return math.sqrt(float(np.square(capsule.supports).sum()) / 3)


def radius_of_gyration(capsule: Capsule) -> float:
    """Of the body without slider about C [m]."""
    return math.sqrt(capsule.inertia / capsule.body_mass)
