"""Simulations of scenes in engines that build mechanisms: a mechanism is put at the start of the
scene, stepped, and its states are read."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import TYPE_CHECKING

import numpy as np

from plumbob.engines.abilities import CompilesScenes
from plumbob.engines.adapters.stepping import (
    OVERFLOW,
    Built,
    Observed,
    SteppedSimulation,
    stepped,
)
from plumbob.engines.method import Unsupported
from plumbob.engines.registry import find_engine
from plumbob.models.scene import Case

if TYPE_CHECKING:  # imported only for types: `plumbob list` needs no records of mechanisms
    from plumbob.engines.mechanism import Mechanism
    from plumbob.engines.stepper import Forces, SceneMechanism, State, Stepper
    from plumbob.models.model_file import ModelFile

Build = Callable[["Mechanism", "State"], "Stepper"]
"""Mechanism, the state in which it will start -> a stepper. In that state loops are closed, and an
engine sees which shapes touch. Raises Unsupported, which names a part that the engine cannot
express."""


def model_file(case: Case) -> ModelFile:
    """The model file of a case's system; raises Unsupported if the system has none."""
    if case.system.model_file is None:
        raise Unsupported(f"{case.system.name} has no model file to make a mechanism of")
    return case.system.model_file


def simulated(
    case: Case,
    step: float,
    build: Build,
    broken: tuple[type[Exception], ...] = OVERFLOW,
    scene: SceneMechanism | None = None,
) -> SteppedSimulation:
    """The simulation of a case at `step` [s] in an engine that builds the case's mechanism, or
    another `scene` in place of that of the case. `broken` are the engine's exceptions if its
    numbers are no longer finite. Raises Unsupported and ParameterError."""
    built_scene = scene or compiled_scene(case)
    # The mechanism is built once, although `stepped` puts the scene at its start for each run.
    stepper = cache(lambda: build(built_scene.mechanism, built_scene.start))
    return stepped(
        case, step, lambda: ready_to_step(case, built_scene, step, stepper()), broken
    )


def compiled_scene(case: Case) -> SceneMechanism:
    """The mechanism of a case with its start and controls; raises Unsupported and
    ParameterError."""
    compiles = find_engine("mujoco").ability(CompilesScenes)
    assert compiles is not None
    return compiles.mechanism(case)


def ready_to_step(
    case: Case,
    scene: SceneMechanism,
    step: float,
    stepper: Stepper,
) -> Built:
    """A case at its start in a stepper, ready to be advanced and read. If the engine tells forces,
    observables that are forces are taken from the step that ends at a sample. Raises
    Unsupported."""
    from plumbob.engines.controlled_steps import controlled_steps
    from plumbob.engines.stepper import TellsForces

    file = model_file(case)
    stepper.put(scene.start)
    advance = controlled_steps(stepper, scene.controls, step)
    observes_forces = file.forces and any(
        observable.force for observable in case.system.observables
    )
    forces = None
    if observes_forces and isinstance(stepper, TellsForces):
        forces = stepper.forces_of_last_step

    def read() -> tuple[State, Forces | None]:
        """The present state, and the forces of the last step if they are observed."""
        return stepper.state(), forces() if forces else None

    return Built(advance, read, file.largest(case.problem), partial(_observed, case, file))


def _observed(
    case: Case, file: ModelFile, samples: Sequence[tuple[State, Forces | None]]
) -> Observed:
    """The observables of states of a case, with observables that are forces if the engine tells
    them; and no channels."""
    states = [state for state, _ in samples]
    forces = [force for _, force in samples if force is not None]
    qpos = np.array([state.qpos for state in states])
    qvel = np.array([state.qvel for state in states])
    observed = dict(file.observe(case.problem, qpos, qvel))
    if forces and file.forces:
        joints = np.array([force.joints for force in forces])
        touching = np.array([force.touching for force in forces])
        observed |= file.forces(case.problem, qpos, qvel, joints, touching)
    return observed, {}
