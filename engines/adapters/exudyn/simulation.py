"""Simulations of scenes in Exudyn. A run is one call of Exudyn's solver, which keeps every state.
If controls are fed back, the solver is called anew for each of them."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial

import numpy as np

from plumbob.engines import sampling
from plumbob.engines.adapters.exudyn.stepper import ExudynStepper
from plumbob.engines.adapters.stepped_mechanism import (
    compiled_scene,
    ready_to_step,
    simulated,
)
from plumbob.engines.adapters.stepping import Built, Followed, FollowedSimulation
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Method, Simulation
from plumbob.engines.stepper import State
from plumbob.models.model_file import Feedback
from plumbob.models.scene import Case

# Exudyn's exceptions if its solver fails
SOLVER_FAILURES = (RuntimeError, ValueError)


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """The simulation of a case by a method at `step` [s]; raises Unsupported and ParameterError."""
    sampling.step_count(case.scene.duration, step)
    scene = compiled_scene(case)

    def build(mechanism: Mechanism, start: State) -> ExudynStepper:
        """The stepper of a mechanism under the controls of the scene."""
        return ExudynStepper(mechanism, method.settings, step, scene.controls)

    if isinstance(scene.controls, Feedback):
        return simulated(case, step, build, SOLVER_FAILURES, scene)
    begin = time.perf_counter()
    stepper = build(scene.mechanism, scene.start)
    uncontrolled = replace(scene, controls=None)  # the stepper has the controls
    built = ready_to_step(case, uncontrolled, step, stepper)
    seconds = time.perf_counter() - begin
    follow = partial(_follow, stepper, built, scene.start)
    return FollowedSimulation(follow, dict, case.scene.duration, seconds, built.limits)


def _follow(
    stepper: ExudynStepper, built: Built, start: State, duration: float, samples: int
) -> Followed:
    """Takes the steps of a duration [s] from a start in one call of the solver."""
    steps = max(1, round(duration / stepper.step))
    why: tuple[str, ...] = ()
    stepper.put(start)
    try:
        stepper.run(steps)
    except SOLVER_FAILURES as error:
        why = (" ".join(str(error).split())[:200],)
    steps_taken = stepper.steps_of_last_run()
    sampled_steps = sampling.sampled(steps, samples)
    sampled_steps = sampled_steps[sampled_steps <= steps_taken]
    observables, _ = built.gather([(state, None) for state in stepper.states(sampled_steps)])
    return Followed(
        times=np.asarray(sampled_steps * stepper.step, dtype=np.float64),
        states=observables,
        evaluations=steps_taken,
        ended=steps_taken == steps,
        why=why,
    )
