"""Simulations of scenes in Pinocchio. Controls are evaluated at the stages of a step, and are not
held for a step."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from plumbob.engines.adapters.pinocchio.stepper import PinocchioStepper
from plumbob.engines.adapters.stepped_mechanism import begun, compiled_scene
from plumbob.engines.adapters.stepping import stepped
from plumbob.engines.method import Method, Simulation
from plumbob.models.scene import Case


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """The simulation of a case by a method at `step` [s]; raises Unsupported and ParameterError."""
    scene = compiled_scene(case)
    integrator = method.scheme.integrator
    stepper = cache(lambda: PinocchioStepper(scene.mechanism, integrator, step, scene.controls))
    uncontrolled = replace(scene, controls=None)  # the stepper evaluates the controls
    return stepped(case, step, lambda: begun(case, uncontrolled, step, stepper()))
