"""Makes the mechanism of a scene from the model file of its system."""

from __future__ import annotations

import numpy as np

from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
from plumbob.engines.adapters.mujoco.options import compiled
from plumbob.engines.adapters.mujoco.translation import filled
from plumbob.engines.mechanism import idealised
from plumbob.engines.method import Unsupported
from plumbob.engines.stepper import SceneMechanism, State
from plumbob.models.scene import Case


def scene_mechanism(case: Case) -> SceneMechanism:
    """The mechanism of a case with its idealisations; raises Unsupported if the system has no model
    file, and ParameterError."""
    file = case.system.model_file
    if file is None:
        raise Unsupported(f"{case.system.name} has no model file to make a mechanism of")
    model = compiled(filled(case.system.mjcf, file, case.problem))
    start = model.key("start")
    return SceneMechanism(
        idealised(compiled_mechanism(model), file.ideal(case.problem)),
        State(np.array(start.qpos), np.array(start.qvel)),
        file.controls(case.problem),
    )
