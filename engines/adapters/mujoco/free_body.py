"""The free rigid body in MuJoCo's terms: a free joint, and nothing that acts on it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from plumbob.analytic.schemes import EULER, LINEARLY_IMPLICIT, RK4_ADDED_RATES, Scheme
from plumbob.engines.adapters.mujoco.translation import (
    Translation,
    at_start,
    bare,
    filled,
)
from plumbob.engines.method import Method, Unsupported
from plumbob.models.free_body.model import MODEL

SMALLEST = 1e-15  # [kg m^2]: the least moment of inertia that MuJoCo takes


def scheme(method: Method) -> Scheme:
    """The scheme of `method` on a body that turns freely: RK4 adds the angular velocities of its
    stages, which belong to different axes; the implicit ones take the derivative of the gyroscopic
    torque, implicitfast and discrete too."""
    integrator = str(method.settings.get("integrator", "Euler")).lower()
    if integrator == "rk4":
        return Scheme(RK4_ADDED_RATES)
    return Scheme(EULER if integrator == "euler" else LINEARLY_IMPLICIT)


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a free body; `problem` is a FreeBody. Raises Unsupported."""
    if min(problem.inertia) < SMALLEST:
        raise Unsupported(f"MuJoCo takes moments of inertia from {SMALLEST:g} kg m^2 on")
    return at_start(bare(filled(mjcf, MODEL, problem)))
