"""What leaving out a model's idle stages and unfelt geoms saves, the motion being the same."""

from __future__ import annotations

import time
from dataclasses import dataclass

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.adapters.mujoco.translation import builder
from plumbob.engines.method import Method
from plumbob.models.scene import Case


@dataclass(frozen=True)
class Saving:
    """Cost of a step [ns] of the model with every stage, with the idle ones left out, and as run:
    without the geoms too; whether all three states at the end are the same to the last bit."""

    ns_default: float
    ns_flags: float
    ns_trimmed: float
    identical: bool


def saving(
    case: Case,
    method: Method,
    step: float = 1e-4,
    steps: int = 1000,
    repeats: int = 31,
) -> Saving:
    """Cost of `steps` steps of `step` [s] from the scene's start, default against trimmed: medians
    of `repeats` turns taken one after the other; raises Unsupported and ParameterError."""
    simulation = compiled(case, method, step)
    trimmed, translation = simulation.model, simulation.translation
    whole = translation.whole or builder(case.system).whole(case.system.mjcf, case.problem)
    options.apply(whole, method.settings, step)
    default, shown = whole.compile(), whole.compile()
    for model in (default, shown):
        translation.tune(model)
    default.opt.disableflags = 0
    shown.opt.disableflags = trimmed.opt.disableflags
    models = (default, shown, trimmed)
    states = np.empty((len(models), trimmed.nq + trimmed.nv))
    seconds = np.empty((repeats, len(models)))
    start = np.concatenate([translation.qpos, translation.qvel])
    held = np.zeros(trimmed.nu)
    if translation.control is not None:
        held = translation.control(np.zeros(1))[0]
    for turn in range(repeats):
        for i in np.roll(np.arange(len(models)), turn):  # each goes first as often as the others
            seconds[turn, i], states[i] = _timed(models[i], start, held, steps)
    ns_default, ns_flags, ns_trimmed = (np.median(seconds, axis=0) / steps * 1e9).tolist()
    return Saving(ns_default, ns_flags, ns_trimmed, identical=bool(np.all(states == states[0])))


def _timed(model: mujoco.MjModel, start: Array, held: Array, steps: int) -> tuple[float, Array]:
    """Processor time [s] of `steps` steps from `start`, qpos and qvel, with the controls `held`,
    and the state at their end.

    Processor time, for waiting while others use the machine is no cost of the model."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = start[: model.nq], start[model.nq :]
    data.ctrl[: len(held)] = held
    begin = time.thread_time()
    mujoco.mj_step(model, data, nstep=steps)
    seconds = time.thread_time() - begin
    return seconds, np.concatenate([data.qpos, data.qvel])
