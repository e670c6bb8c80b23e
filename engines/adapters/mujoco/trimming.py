"""Measures the time saved by leaving out a model's needless stages and visual parts."""

from __future__ import annotations

import copy
from collections.abc import Iterator

import mujoco
import numpy as np

from plumbob.engines.abilities import Trimming
from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.simulation import MujocoSimulation, compiled
from plumbob.engines.adapters.mujoco.translation import with_visual_parts
from plumbob.engines.method import Method
from plumbob.engines.study.cost import TimedSteps, in_turns
from plumbob.models.scene import Case

PARTS = (("geoms", "geom"), ("meshes", "mesh"), ("joints", "joint"))  # list of a spec, its word


def trimming(case: Case, method: Method, step: float, steps: int, repeats: int) -> Trimming:
    """The cost of `steps` steps of `step` [s] from the scene's start, of the complete and the
    trimmed model, timed in turn at most `repeats` times. Raises Unsupported and ParameterError."""
    simulation = compiled(case, method, step)
    trimmed = simulation.model
    translation = simulation.translation
    complete = with_visual_parts(translation, case)
    options.apply(complete, method.settings, step)
    every_stage = complete.compile()
    translation.tune(every_stage)
    needed_stages = copy.copy(every_stage)
    every_stage.opt.disableflags = 0
    needed_stages.opt.disableflags = trimmed.opt.disableflags
    runs = [
        MujocoSimulation(translation, model, steps, step)
        for model in (every_stage, needed_stages, trimmed)
    ]
    timed_runs = {number: TimedSteps(run, 1.0) for number, run in enumerate(runs)}
    costs = [cost.ns_per_step for cost in in_turns(timed_runs, repeats)[0].values()]
    ends = np.array([np.concatenate([run.data.qpos, run.data.qvel]) for run in runs])
    return Trimming(
        ns_default=costs[0],
        ns_flags=costs[1],
        ns_trimmed=costs[2],
        identical=bool((ends == ends[0]).all()),
        stages_off=options.disabled(trimmed.opt.disableflags),
        parts_left_out=tuple(_parts_left_out(complete, translation.spec)),
    )


def _parts_left_out(complete: mujoco.MjSpec, trimmed: mujoco.MjSpec) -> Iterator[str]:
    """Yields the number of parts of each kind that `trimmed` lacks: "2 geoms", "1 mesh"."""
    for field, word in PARTS:
        count = len(getattr(complete, field)) - len(getattr(trimmed, field))
        if count > 0:
            yield f"{count} {word}{'' if count == 1 else 's'}"
