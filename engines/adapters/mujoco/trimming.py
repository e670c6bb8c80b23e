"""Time saved by leaving out a model's needless stages and visual parts, at equal motion."""

from __future__ import annotations

import copy
from collections.abc import Iterator

import mujoco
import numpy as np

from plumbob.engines.abilities import Trimming
from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.simulation import MujocoSimulation, compiled
from plumbob.engines.adapters.mujoco.translation import filled
from plumbob.engines.method import Method
from plumbob.engines.study.cost import TimedSteps, in_turns
from plumbob.models.scene import Case

PARTS = (("geoms", "geom"), ("meshes", "mesh"), ("joints", "joint"))  # counted, and their names


def trimming(
    case: Case, method: Method, step: float = 1e-4, steps: int = 1000, repeats: int = 31
) -> Trimming:
    """Cost of `steps` steps of `step` [s] from the scene's start, default against trimmed, timed in
    turns, `repeats` at most; raises Unsupported and ParameterError."""
    simulation = compiled(case, method, step)
    trimmed = simulation.model
    translation = simulation.translation
    system = case.system
    untrimmed = translation.whole
    if untrimmed is None:
        assert system.model_file is not None  # builders of other systems give the whole model
        untrimmed = filled(system.mjcf, system.model_file, case.problem)
    options.apply(untrimmed, method.settings, step)
    every_stage = untrimmed.compile()
    translation.tune(every_stage)
    shown = copy.copy(every_stage)  # the parts that are shown alone, too
    every_stage.opt.disableflags = 0
    shown.opt.disableflags = trimmed.opt.disableflags
    runs = [
        MujocoSimulation(translation, m, steps, step) for m in (every_stage, shown, trimmed)
    ]
    pieces = {k: TimedSteps(run, 1.0) for k, run in enumerate(runs)}
    default, flags, least = (c.ns_per_step for c in in_turns(pieces, repeats)[0].values())
    ends = np.array([np.concatenate([run.data.qpos, run.data.qvel]) for run in runs])
    return Trimming(
        default,
        flags,
        least,
        bool((ends == ends[0]).all()),
        options.disabled(trimmed.opt.disableflags),
        tuple(_parts_left_out(untrimmed, translation.spec)),
    )


def _parts_left_out(complete: mujoco.MjSpec, trimmed: mujoco.MjSpec) -> Iterator[str]:
    """Number of parts of each kind that `trimmed` omits, with their names."""
    for field, word in PARTS:
        count = len(getattr(complete, field)) - len(getattr(trimmed, field))
        if count > 0:
            yield f"{count} {word}{'' if count == 1 else 's'}"
