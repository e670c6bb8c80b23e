"""Time saved by leaving out a model's needless stages and visual parts, at equal motion."""

from __future__ import annotations

import copy
from collections.abc import Iterator

import mujoco
import numpy as np

from plumbob.engines.abilities import Trimming
from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.adapters.mujoco.timed import TimedPeriods
from plumbob.engines.adapters.mujoco.translation import Translation
from plumbob.engines.method import Method
from plumbob.engines.registry import find_builder
from plumbob.engines.study.cost import Key, TimedSteps, in_turns
from plumbob.models.scene import Case

PARTS = (("geoms", "geom"), ("meshes", "mesh"), ("joints", "joint"))  # counted, and their names


def trimming(
    case: Case, method: Method, step: float = 1e-4, steps: int = 1000, repeats: int = 31
) -> Trimming:
    """Cost of `steps` steps of `step` [s] from the scene's start, default against trimmed, timed in
    turns, `repeats` at most; raises Unsupported and ParameterError."""
    simulation = compiled(case, method, step)
    trimmed, translation = simulation.model, simulation.translation
    complete = find_builder("mujoco", case.system).whole(case.system.mjcf, case.problem)
    parts = tuple(_parts_left_out(complete, translation.spec))
    models = _versions(translation, translation.whole or complete, trimmed, method, step)
    timed, ends = dict[Key, TimedSteps](), []
    for k, model in enumerate(models):
        data, control = mujoco.MjData(model), np.zeros((1, model.nu))
        if translation.control is not None:
            control[:, : trimmed.nu] = translation.control(np.zeros(1))
        start = np.concatenate([translation.qpos, translation.qvel])[None]
        periods = TimedPeriods(model, data, start, control, steps)
        timed[str(k), ""] = TimedSteps(periods, 1.0)
        ends.append(periods.end())
    default, flags, as_run = (cost.ns_per_step for cost in in_turns(timed, repeats)[0].values())
    return Trimming(
        default,
        flags,
        as_run,
        identical=all(np.array_equal(end, ends[0]) for end in ends),
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
