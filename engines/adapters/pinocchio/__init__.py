"""Pinocchio as an engine. Pinocchio computes the accelerations of a mechanism, and has no time
integrator: the integrators are this package's. Errors thus show the accuracy of the equations of
motion alone.

Pinocchio's proximal constraint dynamics closes loops.
"""

from __future__ import annotations

from plumbob.analytic.schemes import EULER, RK4, Scheme
from plumbob.engines.abilities import (
    BuildsMechanisms,
    ModelReader,
    RunsFiles,
    SchemeOfCase,
)
from plumbob.engines.adapters.constrained import CONSTRAINED, constrained
from plumbob.engines.adapters.own_derivatives import derivative_by_mechanisms
from plumbob.engines.adapters.stepping import no_error
from plumbob.engines.method import Engine, Method
from plumbob.models.scene import FREE_ROTATION, ONE_SMOOTH, SMOOTH, Case, later

KINDS = (ONE_SMOOTH, SMOOTH, FREE_ROTATION)
TOUCHING = "!rolling-disc"  # excludes a smooth system whose body touches the ground
METHODS = (
    Method("pinocchio/aba+euler", Scheme(EULER), 1, systems=(TOUCHING,), kinds=KINDS),
    Method(
        "pinocchio/aba+rk4",
        Scheme(RK4),
        4,
        systems=("capsule-line/heading-030", TOUCHING),
        kinds=KINDS,
    ),
)


def scheme(case: Case, method: Method) -> Scheme:
    """The scheme of `method` on this case. If a loop is closed, no theory covers the scheme."""
    return CONSTRAINED if constrained(case) else method.scheme


ENGINE = Engine(
    "pinocchio",
    "pinocchio",
    METHODS,
    later(f"{__name__}.simulation.prepare"),
    no_error,
    optional=True,
    abilities=(
        SchemeOfCase(scheme),
        ModelReader(later(f"{__name__}.user_model.model_fields")),
        derivative_by_mechanisms("rnea", later(f"{__name__}.derivatives.derivatives"), 1e-12),
        RunsFiles(later(f"{__name__}.user_model.user_model")),
        BuildsMechanisms(later(f"{__name__}.simulation.built"), "pinocchio/aba+euler"),
    ),
)
