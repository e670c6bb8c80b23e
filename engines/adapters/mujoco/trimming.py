"""Time saved by leaving out a model's needless stages and visual parts, at equal motion."""

from __future__ import annotations

import copy
import time
from collections.abc import Iterator

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.abilities import Trimming
from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.adapters.mujoco.translation import Translation
from plumbob.engines.method import Method
from plumbob.engines.registry import find_builder
from plumbob.models.scene import Case

# Relative: on a machine that others use, savings then scatter by 1.7 per cent of the whole, after
# the number of turns that it takes, as they do after seven turns.
CLOSE = 0.1
PARTS = (("geoms", "geom"), ("meshes", "mesh"), ("joints", "joint"))  # counted, and their names


def trimming(
    case: Case, method: Method, step: float = 1e-4, steps: int = 1000, repeats: int = 31
) -> Trimming:
    """Cost of `steps` steps of `step` [s] from the scene's start, default against trimmed: medians
    of turns taken one after the other, `repeats` at most, until they agree; raises Unsupported and
    ParameterError."""
    simulation = compiled(case, method, step)
    trimmed, translation = simulation.model, simulation.translation
    complete = find_builder("mujoco", case.system).whole(case.system.mjcf, case.problem)
    parts = tuple(_parts_left_out(complete, translation.spec))
    models = _versions(translation, translation.whole or complete, trimmed, method, step)
    seconds, states = _timed_in_turn(models, translation, steps, repeats)
    middle = np.median(beside(seconds), axis=0) * np.median(seconds.mean(axis=1))
    ns_default, ns_flags, ns_trimmed = (middle / steps * 1e9).tolist()
    return Trimming(
        ns_default,
        ns_flags,
        ns_trimmed,
        identical=bool(np.all(states == states[0])),
        stages_off=tuple(_stages_off(trimmed)),
        parts_left_out=parts,
    )


def _versions(
    translation: Translation,
    untrimmed: mujoco.MjSpec,
    trimmed: mujoco.MjModel,
    method: Method,
    step: float,
) -> tuple[mujoco.MjModel, mujoco.MjModel, mujoco.MjModel]:
    """The model with every stage, with needless ones disabled, and as run: without visual parts."""
    options.apply(untrimmed, method.settings, step)
    default = untrimmed.compile()
    translation.tune(default)
    shown = copy.copy(default)
    default.opt.disableflags = 0
    shown.opt.disableflags = trimmed.opt.disableflags
    return default, shown, trimmed


def _timed_in_turn(
    models: tuple[mujoco.MjModel, ...], translation: Translation, steps: int, repeats: int
) -> tuple[Array, Array]:
    """Processor time [s] of `steps` steps, shape (turns, len(models)), and the states at their
    ends, shape (len(models), nq + nv)."""
    states = np.empty((len(models), models[-1].nq + models[-1].nv))
    seconds = np.empty((repeats, len(models)))
    start = np.concatenate([translation.qpos, translation.qvel])
    data = [mujoco.MjData(model) for model in models]
    ctrl = np.zeros(models[-1].nu)
    if translation.control is not None:
        ctrl = translation.control(np.zeros(1))[0]
    for turn in range(repeats):
        for i in np.roll(np.arange(len(models)), turn):  # each goes first as often as the others
            seconds[turn, i], states[i] = _timed(models[i], data[i], start, ctrl, steps)
        if (turn + 1) % len(models) == 0 and agree(seconds[: turn + 1]):
            return seconds[: turn + 1], states
    return seconds, states


def beside(seconds: Array) -> Array:
    """Times, shape (turns, models), over the mean of their turn, in which others that use the
    machine slow all models equally."""
    return np.asarray(seconds / seconds.mean(axis=1, keepdims=True))


def agree(seconds: Array) -> bool:
    """Whether each model's times, shape (turns, models), over the mean of their turn, differ by
    CLOSE of their median at most."""
    ratios = beside(seconds)
    return bool(np.all(np.ptp(ratios, axis=0) <= CLOSE * np.median(ratios, axis=0)))


def _timed(
    model: mujoco.MjModel, data: mujoco.MjData, start: Array, ctrl: Array, steps: int
) -> tuple[float, Array]:
    """Processor time [s] of `steps` steps from `start`, qpos and qvel, with the controls `ctrl`,
    and the state at their end.

    Processor time, since waiting while others use the machine is no cost of the model."""
    mujoco.mj_resetData(model, data)
    data.qpos[:], data.qvel[:] = start[: model.nq], start[model.nq :]
    data.ctrl[: len(ctrl)] = ctrl
    begin = time.thread_time()
    mujoco.mj_step(model, data, nstep=steps)
    seconds = time.thread_time() - begin
    return seconds, np.concatenate([data.qpos, data.qvel])


def _stages_off(model: mujoco.MjModel) -> Iterator[str]:
    """Names of the stages that `model` leaves out; a reset on divergence is no stage."""
    for name, bit in options.BIT.__members__.items():
        if not name.startswith("mjDSBL_") or bit == options.BIT.mjDSBL_AUTORESET:
            continue
        if model.opt.disableflags & int(bit):
            yield name.removeprefix("mjDSBL_").lower()


def _parts_left_out(complete: mujoco.MjSpec, trimmed: mujoco.MjSpec) -> Iterator[str]:
    """Number of parts of each kind that `trimmed` omits, with their names."""
    for field, word in PARTS:
        count = len(getattr(complete, field)) - len(getattr(trimmed, field))
        if count > 0:
            yield f"{count} {word}{'' if count == 1 else 's'}"
