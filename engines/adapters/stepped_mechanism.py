"""Runs of a scene in an engine that builds mechanisms: put at its start, stepped, and read."""

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

if TYPE_CHECKING:  # this module is loaded at each start, records of mechanisms are not
    from plumbob.engines.mechanism import Mechanism
    from plumbob.engines.stepper import Forces, SceneMechanism, State, Stepper
    from plumbob.models.model_file import ModelFile

Build = Callable[["Mechanism", "State"], "Stepper"]
"""Builds a mechanism, with the state in which it will start: where its loops are closed and its
shapes touch or not. Raises Unsupported, which names the part that the engine does not express."""


def model_file(case: Case) -> ModelFile:
    """How the problem of a case stands in a model file; raises Unsupported."""
    if case.system.model_file is None:
        raise Unsupported(f"{case.system.name} has no model file to make a mechanism of")
    return case.system.model_file


def simulated(
    case: Case,
    step: float,
    build: Build,
    broken: tuple[type[Exception], ...] = OVERFLOW,
    *,
    reads_forces: bool = False,
) -> SteppedSimulation:
    """The simulation of a case at `step` [s] in an engine that builds its mechanism; `broken` are
    the engine's exceptions if its numbers are no longer finite. If the adapter `reads_forces`, the
    forces of the step that ends at a sample are observed. Raises Unsupported and ParameterError."""
    scene = compiled_scene(case)
    stepper = cache(lambda: build(scene.mechanism, scene.start))
    return stepped(
        case, step, lambda: begun(case, scene, step, stepper(), reads_forces), broken
    )


def compiled_scene(case: Case) -> SceneMechanism:
    """The mechanism of a case with its start and its controls; raises Unsupported and
    ParameterError."""
    compiles = find_engine("mujoco").ability(CompilesScenes)
    assert compiles is not None
    return compiles.mechanism(case)


def begun(
    case: Case,
    scene: SceneMechanism,
    step: float,
    stepper: Stepper,
    reads_forces: bool = False,
) -> Built:
    """A case at its start in an engine; raises Unsupported."""
    from plumbob.engines.stepper import TellsForces

    file = model_file(case)
    controls = scene.controls
    stepper.put(scene.start)

    def advance(first: int, last: int) -> None:
        rows = (
            None
            if controls is None
            else controls(step * np.arange(first, last, dtype=np.float64))
        )
        stepper.advance(rows, last - first)

    forced = (
        reads_forces
        and file.forces
        and any(observable.force for observable in case.system.observables)
    )
    forces = stepper.forces if forced and isinstance(stepper, TellsForces) else None

    def read() -> tuple[State, Forces | None]:
        return stepper.state(), forces() if forces else None

    return Built(advance, read, file.largest(case.problem), partial(_observed, case, file))


def _observed(
    case: Case, file: ModelFile, samples: Sequence[tuple[State, Forces | None]]
) -> Observed:
    """What states of a case, and an engine's forces if there are any, show; no channels."""
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
