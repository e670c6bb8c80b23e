"""Simulations of scenes in Exudyn. A run is one call of Exudyn's solver, which keeps every
state."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from plumbob.engines import sampling
from plumbob.engines.adapters.exudyn.stepper import ExudynStepper
from plumbob.engines.adapters.stepped_mechanism import begun, compiled_scene
from plumbob.engines.adapters.stepping import Followed, FollowedSimulation
from plumbob.engines.method import Method, Simulation
from plumbob.models.scene import Case


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """The simulation of a case by a method at `step` [s]; raises Unsupported and ParameterError."""
    lasting = case.scene.duration
    sampling.step_count(lasting, step)
    scene = compiled_scene(case)
    begin = time.perf_counter()
    stepper = ExudynStepper(scene.mechanism, method.settings, step, scene.controls)
    uncontrolled = replace(
        scene, controls=None
    )  # the stepper's solver asks for controls itself
    built = begun(case, uncontrolled, step, stepper)
    seconds = time.perf_counter() - begin

    def follow(duration: float, samples: int) -> Followed:
        steps = max(1, round(duration / step))
        why: tuple[str, ...] = ()
        stepper.put(scene.start)
        try:
            stepper.run(steps)
        except (RuntimeError, ValueError) as error:
            why = (" ".join(str(error).split())[:200],)
        taken = stepper.taken()
        kept = sampling.sampled(steps, samples)
        kept = kept[kept <= taken]
        observed, _ = built.gather([(state, None) for state in stepper.states(kept)])
        times = np.asarray(kept * step, dtype=np.float64)
        return Followed(times, observed, taken, taken == steps, why)

    return FollowedSimulation(follow, dict, lasting, seconds, built.limits)
