"""Runs of a scene in an engine that builds mechanisms: put at its start, stepped, and read."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from plumbob.engines.abilities import CompilesScenes
from plumbob.engines.adapters.stepping import (
    OVERFLOW,
    Built,
    Observed,
    SteppedSimulation,
    stepped,
)
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Unsupported
from plumbob.engines.registry import find_engine
from plumbob.engines.stepper import SceneMechanism, State, Stepper
from plumbob.models.model_file import ModelFile
from plumbob.models.scene import Case

Build = Callable[[Mechanism, State], Stepper]
"""Builds a mechanism, with the state in which it will start: where its loops are closed and its
shapes touch or not. Raises Unsupported, which names the part that the engine does not express."""


def model_file(case: Case) -> ModelFile:
    """How the problem of a case stands in a model file; raises Unsupported."""
    if case.system.model_file is None:
        raise Unsupported(f"{case.system.name} has no model file to make a mechanism of")
    return case.system.model_file


def simulated(
    case: Case, step: float, build: Build, broken: tuple[type[Exception], ...] = OVERFLOW
) -> SteppedSimulation:
    """The simulation of a case at `step` [s] in an engine that builds its mechanism; `broken` are
    the engine's exceptions if its numbers are no longer finite. Raises Unsupported and
    ParameterError."""
    scene = compiled_scene(case)
    return stepped(case, step, lambda: begun(case, scene, step, build), broken)


def compiled_scene(case: Case) -> SceneMechanism:
    """The mechanism of a case with its start and its controls; raises Unsupported and
    ParameterError."""
    compiles = find_engine("mujoco").ability(CompilesScenes)
    assert compiles is not None
    return compiles.mechanism(case)


def begun(case: Case, scene: SceneMechanism, step: float, build: Build) -> Built:
    """A case at its start in an engine; raises Unsupported."""
    file = model_file(case)
    controls = scene.controls
    stepper = build(scene.mechanism, scene.start)
    stepper.put(scene.start)

    def advance(first: int, last: int) -> None:
        rows = (
            None
            if controls is None
            else controls(step * np.arange(first, last, dtype=np.float64))
        )
        stepper.advance(rows, last - first)

    def gather(states: Sequence[State]) -> Observed:
        qpos, qvel = (
            np.array([getattr(state, part) for state in states]) for part in ("qpos", "qvel")
        )
        return file.observe(case.problem, qpos, qvel), {}

    return Built(advance, stepper.state, file.largest(case.problem), gather)
