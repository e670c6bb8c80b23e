"""The timed part of a scene: it fits the budget and is long enough to represent the whole."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.trimming import trimming
from plumbob.engines.registry import method as find_method
from plumbob.engines.study import cost
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of

SCENE = find_scene("simple-pendulum/free-large")  # 50 s


def timed(method: str, step: float, budget: float) -> Any:
    return cost._sized(system_of(SCENE).case(SCENE), find_method(method), step, budget)


@pytest.mark.parametrize(("method", "step"), [("ode/dop853", 1e-8), ("ode/radau", 1e-4)])
def test_a_long_adaptive_run_is_cut(method: str, step: float) -> None:
    piece = timed(method, step, budget=1e-3)
    assert piece.duration <= SCENE.duration / 4
    # The first step of a solver costs more than the rest; from 300 on it is a per cent or two.
    assert cost.EVALUATIONS <= piece.run().steps <= 3 * cost.EVALUATIONS


def test_what_fits_the_budget_is_run_whole() -> None:
    assert timed("ode/dop853", 1e-8, budget=1e3).duration == SCENE.duration
    assert timed("mujoco/euler", 1e-1, budget=1e-9).steps == 500
    assert 2000 <= timed("mujoco/euler", 1e-4, budget=4e-3).steps < 500_000


@dataclass
class Waiting:
    """A simulation that reports 0.1 s and computes for a given part of it."""

    computing: float  # [s]
    compile_seconds: float = 0.0

    def run(self) -> Trajectory:
        begin, spent = time.perf_counter(), time.thread_time()
        while time.thread_time() - spent < self.computing:
            pass
        time.sleep(max(0.0, 0.1 - (time.perf_counter() - begin)))
        return Trajectory(np.zeros(2), {}, steps=1, seconds=time.perf_counter() - begin)


@pytest.mark.parametrize("computing", [0.02, 0.05])
def test_waiting_is_no_cost(computing: float) -> None:
    fraction, run = cost._computing(Waiting(computing).run)
    assert fraction * run.seconds == pytest.approx(computing, rel=0.05)  # the clocks' own calls


@pytest.mark.parametrize("name", ["capsule-turn", "capsule-line", "simple-pendulum/forced-small"])
def test_what_a_model_leaves_out_is_timed_whatever_its_controls(name: str) -> None:
    scene = find_scene(name)
    method = "mujoco/euler+coulomb" if name.startswith("capsule") else "mujoco/euler"
    found = trimming(system_of(scene).case(scene), find_method(method), 1e-4, steps=50, repeats=1)
    assert found.identical
