"""Errors of engines' models of pendulums: the bob, a point in the reference, has a moment of
inertia, and the platform, which should keep its rate, has a finite inertia."""

from __future__ import annotations

from typing import Any

from plumbob.engines.method import Method, ModelError
from plumbob.models.scene import Case

POINTS = ("simple_pendulum", "servo")  # families of systems with a point mass on a rod
POINT = 1e-15  # [kg m^2] moment of inertia of a point mass: engines need one above zero


def model_error(case: Case, method: Method, step: float) -> ModelError:
    """{observable: {reason: bound}} of the errors that the moment of inertia of a bob causes; empty
    for systems without point masses."""
    if case.system.family not in POINTS:
        return {}
    return bob_errors(getattr(case.problem, "started", case.problem), case.scene.duration)


def model_error_on_platform(case: Case, method: Method, step: float) -> ModelError:
    """Bounds on the errors of each observable, by reason, for an engine in which a platform keeps
    its rate by a finite inertia."""
    if case.system.family != "cone_pendulum":
        return model_error(case, method, step)
    return platform_errors(case.problem.started, case.scene.duration)


def platform_errors(problem: Any, duration: float) -> ModelError:
    """Bounds over `duration` [s] on the errors from the finite inertia of a platform."""
    from plumbob.analytic.errors.contact_models.added_inertia import platform_error
    from plumbob.models.cone_pendulum.model import holding_inertia

    errors = platform_error(problem, duration, holding_inertia(problem))
    return {
        name: {"inertia of the platform": bound}
        for name, bound in zip(("theta", "theta_dot"), errors, strict=True)
    }


def bob_errors(problem: Any, duration: float) -> ModelError:
    """Bounds over `duration` [s] on the errors from the moment of inertia of a bob."""
    from plumbob.analytic.errors.contact_models.added_inertia import bob_error

    bounds = bob_error(problem, duration, POINT / (problem.mass * problem.length**2))
    return {name: {"moment of inertia of the bob": bound} for name, bound in bounds.items()}
