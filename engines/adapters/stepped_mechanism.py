"""Runs of a scene in an engine that builds mechanisms: put at its start, stepped, and read."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

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
from plumbob.engines.stepper import Forces, SceneMechanism, State, Stepper, TellsForces
from plumbob.models.model_file import ModelFile
from plumbob.models.scene import Case

Build = Callable[[Mechanism, State], Stepper]
"""Builds a mechanism, with the state in which it will start: where its loops are closed and its
shapes touch or not. Raises Unsupported, which names the part that the engine does not express."""


def _model_file(case: Case) -> ModelFile:
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
    compiles = find_engine("mujoco").ability(CompilesScenes)
    assert compiles is not None
    scene = compiles.mechanism(case)
    stepper = cache(lambda: build(scene.mechanism, scene.start))
    return stepped(case, step, lambda: _begun(case, scene, step, stepper()), broken)


def _begun(case: Case, scene: SceneMechanism, step: float, stepper: Stepper) -> Built:
    """A case at its start in an engine."""
    file = _model_file(case)
    controls = scene.controls
    stepper.put(scene.start)

    def advance(first: int, last: int) -> None:
        rows = (
            None
            if controls is None
            else controls(step * np.arange(first, last, dtype=np.float64))
        )
        stepper.advance(rows, last - first)

    tells = stepper.forces if isinstance(stepper, TellsForces) and file.forces else None

    def read() -> tuple[State, Forces | None]:
        return stepper.state(), tells() if tells else None

    def gather(samples: Sequence[tuple[State, Forces | None]]) -> Observed:
        states, told = zip(*samples, strict=True)
        qpos, qvel = (
            np.array([getattr(state, part) for state in states]) for part in ("qpos", "qvel")
        )
        observed = dict(file.observe(case.problem, qpos, qvel))
        if tells and file.forces:
            joints, touching = (
                np.array([getattr(forces, part) for forces in told])
                for part in ("joints", "touching")
            )
            observed |= file.forces(case.problem, qpos, qvel, joints, touching)
        return observed, {}

    return Built(advance, read, file.largest(case.problem), gather)
