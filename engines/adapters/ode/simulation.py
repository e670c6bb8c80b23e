"""A scene set up for one ODE method and its step or tolerance."""

from __future__ import annotations

import time

import numpy as np

from plumbob.analytic.parameters import ParameterError, positive
from plumbob.engines.adapters import sampling
from plumbob.engines.adapters.ode.adaptive_run import AdaptiveSimulation, solver_called
from plumbob.engines.adapters.ode.equation import builder
from plumbob.engines.adapters.ode.fixed_run import FixedStepSimulation
from plumbob.engines.adapters.ode.fixed_step import advance
from plumbob.engines.method import Method
from plumbob.models.scene import Case

SMALLEST = 100 * float(np.finfo(float).eps)  # the relative tolerance below which scipy won't go


def prepared(case: Case, method: Method, step: float) -> FixedStepSimulation | AdaptiveSimulation:
    """Set up `case` for `method` at `step` [s], or at the relative tolerance `step`; raises
    Unsupported and ParameterError."""
    begin = time.perf_counter()
    if method.control == "step":
        steps = sampling.step_count(case.scene.duration, step)
        equation = builder(case.system).build(case.problem, method)
        integrator = advance(method.scheme.integrator)
        elapsed = time.perf_counter() - begin
        return FixedStepSimulation(equation, integrator, steps, step, elapsed)
    if not SMALLEST <= positive("step", step) < 1.0:
        raise ParameterError("step", step, f"a relative tolerance from {SMALLEST:.1e} to below 1")
    equation = builder(case.system).build(case.problem, method)
    solver = solver_called(method.settings["method"])
    elapsed = time.perf_counter() - begin
    return AdaptiveSimulation(equation, solver, step, case.scene.duration, elapsed)
