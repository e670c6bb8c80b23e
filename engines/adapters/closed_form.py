"""The closed form itself as an engine: no step, no error of its own, and a cost like any other."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.reference import Array, Reference
from plumbob.analytic.schemes import CLOSED_FORM, Scheme
from plumbob.engines.adapters.stepping import no_error
from plumbob.engines.method import Engine, Method, Simulation, Stepping, Unsupported
from plumbob.engines.sampling import SAMPLES
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import FREE_ROTATION, ON_PLANE, ON_SUPPORTS, ONE_SMOOTH, Case

# ULP is the finest representable tolerance.
KINDS = (ONE_SMOOTH, FREE_ROTATION, ON_SUPPORTS, ON_PLANE)
METHODS = (
    Method("exact/closed-form", Scheme(CLOSED_FORM), None, "tolerance", {}, (ULP,), kinds=KINDS),
)


@dataclass
class Evaluation:
    """An exact answer and its sample times; its steps are its samples."""

    reference: Reference
    times: Array
    compile_seconds: float

    def run(self) -> Trajectory:
        """Evaluate the observables at all samples."""
        begin = time.perf_counter()
        observed = self.reference.observe(self.times)
        seconds = time.perf_counter() - begin
        return Trajectory(self.times, observed, steps=len(self.times), seconds=seconds)

    def stepped(self, fraction: float) -> Stepping:
        """As many evaluations within the first `fraction` of the duration."""
        begin = time.thread_time()
        self.reference.observe(fraction * self.times)
        return Stepping(len(self.times), time.thread_time() - begin)


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Compute the constants of the closed form; `step` has no part in it. Raises Unsupported where
    the reference is a series or a quadrature."""
    begin = time.perf_counter()
    reference = case.system.reference(case.problem)
    if getattr(reference, "closed_form", reference) is None:
        raise Unsupported(f"{case.scene.name} has no closed form")
    times = np.linspace(0.0, case.scene.duration, SAMPLES + 1)
    reference.observe(times)
    return Evaluation(reference, times, time.perf_counter() - begin)


ENGINE = Engine("exact", "scipy", METHODS, prepare, no_error)
