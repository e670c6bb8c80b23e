"""Simulations of scenes in Pinocchio. Controls that are functions of time are evaluated at the
stages of a step, and are not held for a step."""

from __future__ import annotations

from dataclasses import replace

from plumbob.engines.adapters.pinocchio.stepper import PinocchioStepper
from plumbob.engines.adapters.stepped_mechanism import compiled_scene, simulated
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Method, Simulation
from plumbob.engines.stepper import State
from plumbob.models.model_file import Feedback
from plumbob.models.scene import Case


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """The simulation of a case by a method at `step` [s]; raises Unsupported and ParameterError."""
    scene = compiled_scene(case)
    controls_at = None
    if not isinstance(scene.controls, Feedback):
        controls_at = scene.controls
        scene = replace(scene, controls=None)  # the stepper evaluates the controls

    def build(mechanism: Mechanism, start: State) -> PinocchioStepper:
        """The stepper of a mechanism by the method's integrator."""
        return PinocchioStepper(mechanism, method.scheme.integrator, step, controls_at)

    return simulated(case, step, build, scene=scene)
