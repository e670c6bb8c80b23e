"""Runs of the capsule's scenes that the findings share, and what a study measured of them."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from types import MappingProxyType

import numpy as np

from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.engines.method import Unsupported, meant
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene

LINE = "capsule-line/ca1"
RED, GREY = "#d55e00", "#808080"
COLOURS = MappingProxyType(
    {
        "mujoco/euler": RED,
        "mujoco/euler+elliptic": "#e69f00",
        "mujoco/euler+coulomb": "#0072b2",
        "mujoco/rk4+coulomb": "#009e73",
        "mujoco/euler+reduced": "#56b4e9",
        "mujoco/euler+tall": RED,
        "pymunk/feet": "#cc79a7",
        "pymunk/side": "#009e73",
    }
)  # of methods, in every figure of the findings; the exact answer is grey where they are shown


@cache
def problem(name: str) -> CapsuleProblem:
    """The problem of a scene."""
    chosen = find_scene(name)
    found = system_of(chosen).problem(chosen.parameters)
    assert isinstance(found, CapsuleProblem)
    return found


@cache
def run(name: str, method: str, step: float) -> Trajectory | None:
    """Run a scene with a step [s]; None where the engine is missing, the method is not meant for
    the scene, or the run does not reach its end."""
    chosen, how = find_scene(name), find_method(method)
    if not installed(engine_of(how)) or not meant(how, chosen):
        return None
    try:
        found = engine_of(how).prepare(case_of(chosen), how, step).run()
    except Unsupported:
        return None
    return found if found.diverged_at is None else None


def displaced(name: str, method: str, step: float) -> float | None:
    """Displacement at the end of a run [m], or None where there is no such run."""
    found = run(name, method, step)
    return None if found is None else float(found.observables["displacement"][-1])


def off(name: str, method: str, step: float) -> float | None:
    """Relative error of the displacement at the end of a run, or None."""
    found = displaced(name, method, step)
    return None if found is None else found / float(problem(name).motion.displacement) - 1.0


def measured(study: Study, scene: str, method: str, step: float) -> Measurement | None:
    """What a study measured of a scene with a method at a step [s], or None."""
    for convergence_study in study.convergence:
        if (convergence_study.scene, convergence_study.method) == (scene, method):
            for found in convergence_study.measurements:
                if found.status == "done" and np.isclose(found.step, step, rtol=1e-9):
                    return found
    return None


def names(study: Study, engines: Iterable[str] = ("mujoco", "pymunk")) -> tuple[str, ...]:
    """Methods of a study by name, of these engines."""
    return tuple(method.name for method in study.methods if method.engine in engines)


def covers(study: Study, *scenes: str) -> bool:
    """Whether a study has all of these scenes."""
    return set(scenes) <= {scene.name for scene in study.scenes}
