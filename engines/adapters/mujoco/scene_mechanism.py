"""Makes the mechanism of a scene from the model file of its system, and a drawing of the scene."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
from plumbob.engines.adapters.mujoco.options import collected, compiled
from plumbob.engines.adapters.mujoco.solids import solids
from plumbob.engines.adapters.mujoco.stepper import MujocoStepper
from plumbob.engines.adapters.mujoco.translation import filled
from plumbob.engines.controlled_steps import controlled_steps
from plumbob.engines.drawn_mechanism import SceneDrawing, drawn_mechanism
from plumbob.engines.mechanism import idealised
from plumbob.engines.method import Unsupported
from plumbob.engines.stepper import Diverged, SceneMechanism, State
from plumbob.models.model_file import ModelFile
from plumbob.models.scene import Case

# Largest number of steps that are taken for the motion of a replay, so that it takes bounded time.
# After these steps the coordinates stay as they are. A model whose slider has contacts may need
# more steps, but its coordinates that no observable shows hardly change.
MOST_DRAWN_STEPS = 20_000


def scene_mechanism(case: Case) -> SceneMechanism:
    """The mechanism of a case with its idealisations; raises Unsupported if the system has no model
    file, and ParameterError."""
    return _with_start(case, *_model_of(case))


def _model_of(case: Case) -> tuple[ModelFile, Any]:
    """Returns the model file of a case's system, and the compiled model with the numbers of the
    case; raises Unsupported if there is none, and ParameterError."""
    file = case.system.model_file
    if file is None:
        raise Unsupported(f"{case.system.name} has no model file to make a mechanism of")
    return file, compiled(filled(case.system.mjcf, file, case.problem))


def _with_start(case: Case, file: ModelFile, model: Any) -> SceneMechanism:
    """Returns the mechanism of a compiled model with the idealisations and start of a case."""
    start = model.key("start")
    return SceneMechanism(
        idealised(compiled_mechanism(model), file.ideal(case.problem)),
        State(np.array(start.qpos), np.array(start.qvel)),
        file.controls(case.problem),
    )


def scene_drawing(case: Case, samples: int) -> SceneDrawing:
    """Returns the mechanism of a case as replays draw it, and its coordinates at `samples` samples
    over the case's duration, by the model file's own steps. Raises Unsupported and
    ParameterError."""
    with collected():
        file, model = _model_of(case)
        scene = _with_start(case, file, model)
        stepper = MujocoStepper(model)
        times = np.linspace(0.0, case.scene.duration, samples)
        stepper.put(scene.start)
        mujoco.mj_forward(model, stepper.data)
        shapes = tuple(solids(model, stepper.data))
        coordinates = _stepped(stepper, scene, times)
    return SceneDrawing(drawn_mechanism(scene.mechanism, shapes), coordinates)


def _stepped(stepper: MujocoStepper, scene: SceneMechanism, times: Array) -> Array:
    """Returns the coordinates at times [s], shape (n, coordinates), in steps of the model. They
    stay as they are after MOST_DRAWN_STEPS, or if the motion diverges."""
    ends = np.minimum(np.rint(times / stepper.step), MOST_DRAWN_STEPS).astype(int).tolist()
    coordinates = np.tile(scene.start.qpos, (len(times), 1))
    stepper.put(scene.start)
    take_steps = controlled_steps(stepper, scene.controls, stepper.step)
    for number, (first, last) in enumerate(pairwise(ends), start=1):
        try:
            take_steps(first, last)
        except (Diverged, mujoco.FatalError):
            coordinates[number:] = coordinates[number - 1]
            break
        coordinates[number] = stepper.state().qpos
    return coordinates
