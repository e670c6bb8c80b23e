"""The free rigid body in MuJoCo: a free joint without forces."""

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

SMALLEST = 1e-15  # [kg m^2] smallest moment of inertia that MuJoCo allows


def scheme(method: Method) -> Scheme:
    """The scheme of `method` on a body that turns freely. RK4 adds angular velocities of its stages
    although they belong to different axes. Implicit integrators, implicitfast and discrete among
    them, take the derivative of the gyroscopic torque."""
    integrator = str(method.settings.get("integrator", "Euler")).lower()
    if integrator == "rk4":
        return Scheme(RK4_ADDED_RATES)
    return Scheme(EULER if integrator == "euler" else LINEARLY_IMPLICIT)


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """The translation of a FreeBody; raises Unsupported."""
    if min(problem.inertia) < SMALLEST:
        raise Unsupported(f"MuJoCo takes moments of inertia from {SMALLEST:g} kg m^2 on")
    return at_start(bare(filled(mjcf, MODEL, problem)))
