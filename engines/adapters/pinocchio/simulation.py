"""Simulations of scenes in Pinocchio. Controls that are functions of time are evaluated at the
stages of a step, and are not held for a step."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from plumbob.engines.adapters.pinocchio.stepper import PinocchioStepper
from plumbob.engines.adapters.stepped_mechanism import compiled_scene, ready_to_step
from plumbob.engines.adapters.stepping import stepped
from plumbob.engines.method import Method, Simulation
from plumbob.models.model_file import Feedback
from plumbob.models.scene import Case


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """The simulation of a case by a method at `step` [s]; raises Unsupported and ParameterError."""
    scene = compiled_scene(case)
    integrator = method.scheme.integrator
    controls_at = None
    if not isinstance(scene.controls, Feedback):
        controls_at = scene.controls
        scene = replace(scene, controls=None)  # the stepper evaluates the controls
    stepper = cache(lambda: PinocchioStepper(scene.mechanism, integrator, step, controls_at))
    return stepped(case, step, lambda: ready_to_step(case, scene, step, stepper()))
