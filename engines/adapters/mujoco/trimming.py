"""Measures the time saved by leaving out a model's needless stages and visual parts."""

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

PARTS = (("geoms", "geom"), ("meshes", "mesh"), ("joints", "joint"))  # list of a spec, its word


def trimming(
    case: Case, method: Method, step: float = 1e-4, steps: int = 1000, repeats: int = 31
) -> Trimming:
    """The cost of `steps` steps of `step` [s] from the scene's start, of the complete and the
    trimmed model, timed in turn at most `repeats` times. Raises Unsupported and ParameterError."""
    simulation = compiled(case, method, step)
    trimmed = simulation.model
    translation = simulation.translation
    system = case.system
    untrimmed = translation.whole
    if untrimmed is None:
        assert system.model_file is not None  # otherwise the builder gives the whole model
        untrimmed = filled(system.mjcf, system.model_file, case.problem)
    options.apply(untrimmed, method.settings, step)
    every_stage = untrimmed.compile()
    translation.tune(every_stage)
    with_visual_parts = copy.copy(every_stage)
    every_stage.opt.disableflags = 0
    with_visual_parts.opt.disableflags = trimmed.opt.disableflags
    runs = [
        MujocoSimulation(translation, model, steps, step)
        for model in (every_stage, with_visual_parts, trimmed)
    ]
    pieces = {k: TimedSteps(run, 1.0) for k, run in enumerate(runs)}
    costs = [cost.ns_per_step for cost in in_turns(pieces, repeats)[0].values()]
    ends = np.array([np.concatenate([run.data.qpos, run.data.qvel]) for run in runs])
    return Trimming(
        ns_default=costs[0],
        ns_flags=costs[1],
        ns_trimmed=costs[2],
        identical=bool((ends == ends[0]).all()),
        stages_off=options.disabled(trimmed.opt.disableflags),
        parts_left_out=tuple(_parts_left_out(untrimmed, translation.spec)),
    )


def _parts_left_out(complete: mujoco.MjSpec, trimmed: mujoco.MjSpec) -> Iterator[str]:
    """Yields the number of parts of each kind that `trimmed` lacks: "2 geoms", "1 mesh"."""
    for field, word in PARTS:
        count = len(getattr(complete, field)) - len(getattr(trimmed, field))
        if count > 0:
            yield f"{count} {word}{'' if count == 1 else 's'}"
