"""The model that MuJoCo steps for a scene, made ready for an audit like a user's model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.engines.adapters.mujoco.own_model.model import MujocoModel, own_model
from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.controlled_steps import given_controls
from plumbob.engines.method import Method
from plumbob.engines.own_motion import Start
from plumbob.models.scene import Case


def scene_model(
    case: Case, method: Method, step: float
) -> tuple[MujocoModel, Callable[[Array], Signals]]:
    """Returns the model that a method of MuJoCo's steps for a case at `step` [s], and a function of
    the model's states, shape (n, k), that returns the observables that states determine, shape (n,)
    each. Raises Unsupported, ParameterError and NotCertifiable."""
    simulation = compiled(case, method, step)
    translation = simulation.translation
    mjmodel = simulation.model
    # The continuous motion needs no integrator, but one that is refused would be an error
    mjmodel.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    start = Start(qpos=translation.qpos.tolist(), qvel=translation.qvel.tolist())
    control = translation.changing_control or given_controls(translation.control)
    model = own_model(mjmodel, case.scene.name, start)
    if control is not None:
        model = replace(model, drive=lambda time: control(np.array([time]))[0])

    def observables(states: Array) -> Signals:
        """Returns the observables of states."""
        velocities = model.layout.velocity
        return translation.observed(states[:, : velocities.start], states[:, velocities])[0]

    return model, observables
