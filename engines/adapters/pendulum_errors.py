"""What engines' models of pendulums add to the error: the moment of inertia of a bob that should be
a point, and the inertia of a platform that should keep its rate."""

from __future__ import annotations

from typing import Any

from plumbob.engines.method import Method, ModelError
from plumbob.models.scene import Case

POINTS = ("simple_pendulum", "servo")  # families of a point on a rod, or like one
POINT = 1e-15  # [kg m^2] of a bob that is a point: engines want moments of inertia above zero


def model_error(case: Case, method: Method, step: float) -> ModelError:
    """Bounds on the error that an engine's model makes of each observable, by reason: the bob, a
    point in the reference, has a moment of inertia in the engine. Empty for other systems, whose
    bodies have inertia, and where the rate of a platform is prescribed exactly."""
    if case.system.family not in POINTS:
        return {}
    return bob_errors(getattr(case.problem, "started", case.problem), case.scene.duration)


def model_error_on_platform(case: Case, method: Method, step: float) -> ModelError:
    """Bounds on the model's error of each observable, by reason, in an engine whose platform keeps
    its rate by an inertia that is finite."""
    if case.system.family != "cone_pendulum":
        return model_error(case, method, step)
    return platform_errors(case.problem.started, case.scene.duration)


def platform_errors(problem: Any, duration: float) -> ModelError:
    """Bounds over `duration` [s] from the inertia of a platform that should keep its rate."""
    from plumbob.analytic.errors.contact_models.added_inertia import platform_error
    from plumbob.models.cone_pendulum.model import holding_inertia

    errors = platform_error(problem, duration, holding_inertia(problem))
    return {
        name: {"inertia of the platform": bound}
        for name, bound in zip(("theta", "theta_dot"), errors, strict=True)
    }


def bob_errors(problem: Any, duration: float) -> ModelError:
    """Bounds over `duration` [s] from the moment of inertia of a bob that should be a point."""
    from plumbob.analytic.errors.contact_models.added_inertia import bob_error

    bounds = bob_error(problem, duration, POINT / (problem.mass * problem.length**2))
    return {name: {"moment of inertia of the bob": bound} for name, bound in bounds.items()}
