"""The closed form as an engine: it has no step and no error, and a cost like any other engine."""

from __future__ import annotations

import time

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.schemes import CLOSED_FORM, Scheme
from plumbob.engines.adapters.stepping import Followed, FollowedSimulation
from plumbob.engines.method import Engine, Method, Simulation, Unsupported, no_error
from plumbob.engines.sampling import MAX_SAMPLES
from plumbob.models.scene import FREE_ROTATION, ON_PLANE, ON_SUPPORTS, ONE_SMOOTH, Case

KINDS = (ONE_SMOOTH, FREE_ROTATION, ON_SUPPORTS, ON_PLANE)
# ULP is the finest representable tolerance.
METHODS = (
    Method(
        "exact/closed-form", Scheme(CLOSED_FORM), None, "tolerance", {}, (ULP,), kinds=KINDS
    ),
)


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Computes the constants of the closed form; `step` is not used. Raises Unsupported if the
    reference is a series or a quadrature."""
    begin = time.perf_counter()
    reference = case.system.reference(case.problem)
    if getattr(reference, "closed_form", reference) is None:
        raise Unsupported(f"{case.scene.name} has no closed form")

    def follow(duration: float, samples: int) -> Followed:
        """Evaluates the closed form over a duration [s], whatever the number of samples."""
        times = np.linspace(0.0, duration, MAX_SAMPLES + 1)
        return Followed(times, reference.observe(times), len(times))

    follow(case.scene.duration, MAX_SAMPLES)
    seconds = time.perf_counter() - begin
    return FollowedSimulation(follow, lambda observed: observed, case.scene.duration, seconds)


ENGINE = Engine("exact", "scipy", METHODS, prepare, no_error)
