"""Simulations of scenes in Exudyn. A run is one call of Exudyn's solver, which keeps every state.
If controls are fed back, the solver is called anew for each of them."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import cache

import numpy as np

from plumbob.engines import sampling
from plumbob.engines.adapters.exudyn.stepper import ExudynStepper
from plumbob.engines.adapters.stepped_mechanism import compiled_scene, ready_to_step
from plumbob.engines.adapters.stepping import Built, Followed, FollowedSimulation, stepped
from plumbob.engines.method import Method, Simulation
from plumbob.models.model_file import Feedback
from plumbob.models.scene import Case

# Exudyn's exceptions if its solver fails
SOLVER_FAILURES = (RuntimeError, ValueError)


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """The simulation of a case by a method at `step` [s]; raises Unsupported and ParameterError."""
    scene_duration = case.scene.duration
    sampling.step_count(scene_duration, step)
    scene = compiled_scene(case)
    if isinstance(scene.controls, Feedback):
        feedback_stepper = cache(
            lambda: ExudynStepper(scene.mechanism, method.settings, step, scene.controls)
        )

        def build() -> Built:
            """Returns the case at its start, in the stepper."""
            return ready_to_step(case, scene, step, feedback_stepper())

        return stepped(case, step, build, SOLVER_FAILURES)
    begin = time.perf_counter()
    stepper = ExudynStepper(scene.mechanism, method.settings, step, scene.controls)
    uncontrolled = replace(scene, controls=None)  # the stepper has the controls
    built = ready_to_step(case, uncontrolled, step, stepper)
    seconds = time.perf_counter() - begin

    def follow(duration: float, samples: int) -> Followed:
        steps = max(1, round(duration / step))
        why: tuple[str, ...] = ()
        stepper.put(scene.start)
        try:
            stepper.run(steps)
        except SOLVER_FAILURES as error:
            why = (" ".join(str(error).split())[:200],)
        steps_taken = stepper.steps_of_last_run()
        sampled_steps = sampling.sampled(steps, samples)
        sampled_steps = sampled_steps[sampled_steps <= steps_taken]
        states = stepper.states(sampled_steps)
        observables, _ = built.gather([(state, None) for state in states])
        return Followed(
            times=np.asarray(sampled_steps * step, dtype=np.float64),
            states=observables,
            evaluations=steps_taken,
            ended=steps_taken == steps,
            why=why,
        )

    return FollowedSimulation(follow, dict, scene_duration, seconds, built.limits)
